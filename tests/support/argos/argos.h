// A stand-in for what the target argos uses of ARGoS 3: its names, and a small world without bodies that touch.

#ifndef STANDIN_ARGOS_H
#define STANDIN_ARGOS_H

#include <cmath>
#include <cstdint>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace argos {

using Real = double;
using UInt8 = uint8_t;
using UInt16 = uint16_t;
using UInt32 = uint32_t;
using TConfigurationNode = std::map<std::string, std::string>;

#define THROW_ARGOSEXCEPTION(what)       \
    {                                    \
        std::ostringstream text;         \
        text << what;                    \
        throw std::runtime_error(text.str()); \
    }

struct CRadians {
    Real value = 0.0;
    bool operator<(const CRadians& other) const { return value < other.value; }
};
struct CDegrees {
    explicit CDegrees(Real x) : value(x) {}
    Real value;
};
inline std::istream& operator>>(std::istream& in, CDegrees& x) { return in >> x.value; }
inline CRadians Abs(const CRadians& x) { return {std::abs(x.value)}; }
inline CRadians ToRadians(const CDegrees& x) { return {x.value * M_PI / 180.0}; }

template <class T>
void GetNodeAttribute(TConfigurationNode& node, const std::string& name, T& value) {
    if (!node.count(name)) {
        THROW_ARGOSEXCEPTION("Attribute '" << name << "' does not exist");
    }
    std::istringstream(node[name]) >> value;
}
template <class T>
void GetNodeAttributeOrDefault(TConfigurationNode& node, const std::string& name, T& value, const T& usual) {
    value = usual;
    if (node.count(name)) {
        GetNodeAttribute(node, name, value);
    }
}

class CVector2 {
  public:
    CVector2(Real x = 0.0, Real y = 0.0) : m_x(x), m_y(y) {}
    CVector2(Real length, const CRadians& angle) : m_x(length * cos(angle.value)), m_y(length * sin(angle.value)) {}
    Real GetX() const { return m_x; }
    Real GetY() const { return m_y; }
    Real Length() const { return std::hypot(m_x, m_y); }
    CRadians Angle() const { return {std::atan2(m_y, m_x)}; }
    CVector2& operator+=(const CVector2& other) { return *this = CVector2(m_x + other.m_x, m_y + other.m_y); }
    CVector2 operator/(Real x) const { return CVector2(m_x / x, m_y / x); }

  private:
    Real m_x, m_y;
};

template <class T>
struct CRange {
    CRange(T low, T high) : low(low), high(high) {}
    T low, high;
};

struct CRandom {
    class CRNG {
      public:
        bool Bernoulli(Real share = 0.5) { return Draw() < share; }
        UInt32 Uniform(const CRange<UInt32>& range) { return range.low + UInt32(Draw() * (range.high - range.low)); }
        Real Exponential(Real mean) { return -mean * std::log(1.0 - Draw()); }

      private:
        Real Draw() {
            m_state ^= m_state << 13;
            m_state ^= m_state >> 17;
            m_state ^= m_state << 5;
            return m_state / 4294967296.0;
        }
        UInt32 m_state = 2463534242u;
    };
    static CRNG* CreateRNG(const std::string&) {
        static CRNG all;
        return &all;
    }
};

class CByteArray {
  public:
    CByteArray(size_t size = 0, UInt8 byte = 0) : m_bytes(size, byte) {}
    size_t Size() const { return m_bytes.size(); }
    const UInt8* ToCArray() const { return m_bytes.data(); }
    UInt8* ToCArray() { return m_bytes.data(); }

  private:
    std::vector<UInt8> m_bytes;
};

struct CCI_Sensor {
    virtual ~CCI_Sensor() {}
};
struct CCI_Actuator {
    virtual ~CCI_Actuator() {}
};
template <class READING>
struct CReadings : CCI_Sensor {
    const std::vector<READING>& GetReadings() const { return readings; }
    std::vector<READING> readings;
};
struct SGround {
    Real Value = 0.0;
};
struct SNear {
    Real Value = 0.0;
    CRadians Angle;
};
struct SPacket {
    CByteArray Data;
};
struct CCI_FootBotMotorGroundSensor : CReadings<SGround> {};
struct CCI_FootBotProximitySensor : CReadings<SNear> {};
struct CCI_KheperaIVGroundSensor : CReadings<SGround> {};
struct CCI_KheperaIVProximitySensor : CReadings<SNear> {};
struct CCI_RangeAndBearingSensor : CReadings<SPacket> {};

struct CCI_DifferentialSteeringActuator : CCI_Actuator {
    void SetLinearVelocity(Real l, Real r) { left = l, right = r; }
    Real left = 0.0, right = 0.0;
};
struct CCI_RangeAndBearingActuator : CCI_Actuator {
    size_t GetSize() const { return data.Size(); }
    void SetData(const CByteArray& bytes) { data = bytes; }
    void ClearData() { data = CByteArray(data.Size()); }
    CByteArray data;
};

class CCI_Controller {
  public:
    virtual ~CCI_Controller() {}
    virtual void Init(TConfigurationNode&) {}
    virtual void ControlStep() {}
    virtual void Reset() {}
    virtual void Destroy() {}
    const std::string& GetId() const { return id; }
    bool HasSensor(const std::string& type) const { return sensors.count(type) != 0; }
    template <class T>
    T* GetSensor(const std::string& type) {
        return dynamic_cast<T*>(sensors.at(type));
    }
    template <class T>
    T* GetActuator(const std::string& type) {
        return dynamic_cast<T*>(actuators.at(type));
    }
    std::string id;
    std::map<std::string, CCI_Sensor*> sensors;
    std::map<std::string, CCI_Actuator*> actuators;
};

struct CColor {
    Real grey;
    static const CColor BLACK, WHITE;
};
inline const CColor CColor::BLACK{0.0}, CColor::WHITE{1.0};

struct CControllableEntity {
    CCI_Controller& GetController() { return *controller; }
    CCI_Controller* controller;
};
template <class T>
T any_cast(const T& x) {
    return x;
}
struct CSpace {
    using TMapPerType = std::map<std::string, CControllableEntity*>;
    TMapPerType& GetEntitiesByType(const std::string&) { return entities; }
    UInt32 GetSimulationClock() const { return clock; }
    TMapPerType entities;
    UInt32 clock = 0;
};
struct CSimulator {
    static CSimulator& GetInstance() {
        static CSimulator only;
        return only;
    }
    UInt32 GetRandomSeed() const { return 7; }
    CSpace space;
};
struct CPhysicsEngine {
    static Real GetSimulationClockTick() { return 0.1; }
};
class CLoopFunctions {
  public:
    virtual ~CLoopFunctions() {}
    virtual void Init(TConfigurationNode&) {}
    virtual void Reset() {}
    virtual void Destroy() {}
    virtual CColor GetFloorColor(const CVector2&) { return CColor::WHITE; }
    virtual void PostExperiment() {}
    CSpace& GetSpace() { return CSimulator::GetInstance().space; }
};

template <class T>
std::map<std::string, T* (*)()>& Registered() {
    static std::map<std::string, T* (*)()> all;
    return all;
}
template <class T>
struct CFactory {
    static bool Exists(const std::string& label) { return Registered<T>().count(label) != 0; }
};
#define REGISTER(KIND, CLASS, LABEL)                                                      \
    static const bool CLASS##_known =                                                     \
        argos::Registered<argos::KIND>().insert_or_assign(LABEL, []() -> argos::KIND* {   \
            return new CLASS;                                                             \
        }).second;
#define REGISTER_CONTROLLER(CLASS, LABEL) REGISTER(CCI_Controller, CLASS, LABEL)
#define REGISTER_LOOP_FUNCTIONS(CLASS, LABEL) REGISTER(CLoopFunctions, CLASS, LABEL)

}  // namespace argos

#endif
