#include "swarmcensus_robot.h"

#include <argos3/plugins/robots/foot-bot/control_interface/ci_footbot_motor_ground_sensor.h>
#include <argos3/plugins/robots/foot-bot/control_interface/ci_footbot_proximity_sensor.h>
#if __has_include(<argos3/plugins/robots/kheperaiv/control_interface/ci_kheperaiv_ground_sensor.h>)
#include <argos3/plugins/robots/kheperaiv/control_interface/ci_kheperaiv_ground_sensor.h>
#include <argos3/plugins/robots/kheperaiv/control_interface/ci_kheperaiv_proximity_sensor.h>
#define HAS_KHEPERAIV
#endif

#include <algorithm>
#include <cmath>

using namespace argos;

inline UInt32 SWARMCENSUS_ROBOTS = 0;  // so far, of all brains and libraries

template <class GROUND, class PROXIMITY>
void CSwarmcensusRobot::Use(const std::string& str_ground, const std::string& str_proximity, Real f_wheel_distance) {
    auto* pcGround = GetSensor<GROUND>(str_ground);
    auto* pcProximity = GetSensor<PROXIMITY>(str_proximity);
    m_cGround = [pcGround] { return pcGround->GetReadings()[0].Value; };
    m_cObstacle = [pcProximity] {
        CVector2 cSum;
        for (const auto& sReading : pcProximity->GetReadings()) {
            cSum += CVector2(sReading.Value, sReading.Angle);
        }
        return cSum / Real(pcProximity->GetReadings().size());
    };
    m_fWheelDistance = f_wheel_distance;
}

// The last number is free again: <distribute> makes another robot for each place that it tries.
CSwarmcensusRobot::~CSwarmcensusRobot() { SWARMCENSUS_ROBOTS -= m_unNumber + 1u == SWARMCENSUS_ROBOTS; }

void CSwarmcensusRobot::Init(TConfigurationNode& t_tree) {
    m_pcWheels = GetActuator<CCI_DifferentialSteeringActuator>("differential_steering");
    m_pcSay = GetActuator<CCI_RangeAndBearingActuator>("range_and_bearing");
    m_pcHear = GetSensor<CCI_RangeAndBearingSensor>("range_and_bearing");
    if (HasSensor("footbot_motor_ground")) {
        Use<CCI_FootBotMotorGroundSensor, CCI_FootBotProximitySensor>(
            "footbot_motor_ground", "footbot_proximity", 0.14);
#ifdef HAS_KHEPERAIV
    } else if (HasSensor("kheperaiv_ground")) {
        Use<CCI_KheperaIVGroundSensor, CCI_KheperaIVProximitySensor>(
            "kheperaiv_ground", "kheperaiv_proximity", 0.1054);
#endif
    } else {
        THROW_ARGOSEXCEPTION("robot \"" << GetId() << "\" needs the sensors footbot_motor_ground and footbot_proximity, "
                             "or kheperaiv_ground and kheperaiv_proximity and the plugin of the Khepera IV");
    }
    GetNodeAttribute(t_tree, "b", m_fB);
    GetNodeAttribute(t_tree, "w", m_fW);
    GetNodeAttributeOrDefault(t_tree, "true_b", m_fTrueB, m_fB);
    GetNodeAttributeOrDefault(t_tree, "true_w", m_fTrueW, m_fW);
    GetNodeAttributeOrDefault(t_tree, "threshold", m_fThreshold, m_fThreshold);
    GetNodeAttributeOrDefault(t_tree, "round_ticks", m_unRoundTicks, m_unRoundTicks);
    GetNodeAttributeOrDefault(t_tree, "speed", m_fSpeed, m_fSpeed);
    GetNodeAttributeOrDefault(t_tree, "turn_speed", m_fTurnSpeed, m_fTurnSpeed);
    GetNodeAttributeOrDefault(t_tree, "straight_mean", m_fStraightMean, m_fStraightMean);
    GetNodeAttributeOrDefault(t_tree, "turn_most", m_unTurnMost, m_unTurnMost);
    GetNodeAttributeOrDefault(t_tree, "avoid_above", m_fAvoidAbove, m_fAvoidAbove);
    GetNodeAttributeOrDefault(t_tree, "avoid_within", m_cAvoidWithin, m_cAvoidWithin);
    for (const Real fShare : {m_fB, m_fW, m_fTrueB, m_fTrueW}) {
        if (!(fShare >= 0.0 && fShare <= 1.0)) {
            THROW_ARGOSEXCEPTION("robot \"" << GetId() << "\": b, w, true_b and true_w should be from 0 to 1");
        }
    }
    if (!(m_fSpeed > 0.0 && m_fTurnSpeed > 0.0 && m_fStraightMean > 0.0)) {
        THROW_ARGOSEXCEPTION("robot \"" << GetId() << "\": speed, turn_speed and straight_mean should be above 0");
    }
    if (m_unRoundTicks < 1 || m_unRoundTicks > 0xFFFF) {
        THROW_ARGOSEXCEPTION("robot \"" << GetId() << "\": round_ticks should be from 1 to 65535");
    }
    if (m_unTurnMost > 0xFFFF) {
        THROW_ARGOSEXCEPTION("robot \"" << GetId() << "\": turn_most should be from 0 to 65535");
    }
    if (m_pcSay->GetSize() < DatagramBytes()) {
        THROW_ARGOSEXCEPTION("robot \"" << GetId() << "\": rab_data_size is " << m_pcSay->GetSize()
                             << ", and the brain " << Label().Name << " needs " << DatagramBytes() << " bytes");
    }
    if (SWARMCENSUS_ROBOTS > 0xFFFF) {
        THROW_ARGOSEXCEPTION("there are more than 65,536 robots");
    }
    m_unNumber = UInt16(SWARMCENSUS_ROBOTS++);
    m_pcRNG = CRandom::CreateRNG("argos");
    Begin();
}

void CSwarmcensusRobot::Begin() {
    m_unStep = m_unRead = m_unHeard = m_unBlacks = m_unLooks = m_unAvoiding = m_unLeft = 0;
    m_fEstimate = 0.5;
    Start();
}

void CSwarmcensusRobot::Reset() {
    Begin();
    if (!m_strLogs.empty()) {
        Record(m_strLogs, m_fTicksPerSecond);
    }
}

void CSwarmcensusRobot::Record(const std::string& str_folder, Real f_ticks_per_second) {
    m_strLogs = str_folder;
    m_fTicksPerSecond = f_ticks_per_second;
    OpenLog(str_folder + "/robot-" + std::to_string(m_unNumber) + ".log",
            UInt32(1000.0 * m_unRoundTicks / f_ticks_per_second + 0.5));
}

void CSwarmcensusRobot::ControlStep() {
    ++m_unStep;
    if (m_unAvoiding == 0 && !IsDone()) {
        Look();
    }
    if (m_unStep % m_unRoundTicks == 0) {
        Round();
    }
    Walk();
}

// One reading of the simulated sensor.
void CSwarmcensusRobot::Look() {
    const bool bBlack = m_cGround() < m_fThreshold;
    const bool bRight = m_pcRNG->Bernoulli(bBlack ? m_fTrueB : m_fTrueW);
    m_unBlacks += bBlack == bRight;
    ++m_unLooks;
    ++m_unRead;
}

void CSwarmcensusRobot::Round() {
    Observe(m_unBlacks, m_unLooks);
    m_unBlacks = m_unLooks = 0;
    CByteArray cDatagram(m_pcSay->GetSize(), 0);
    if (Say(cDatagram.ToCArray())) {
        m_pcSay->SetData(cDatagram);
    } else {
        m_pcSay->ClearData();
    }
    for (const auto& sPacket : m_pcHear->GetReadings()) {
        m_unHeard += Hear(sPacket.Data.ToCArray());  // zeros are silence
    }
    m_fEstimate = End(UInt32(1000.0 * m_unStep / m_fTicksPerSecond));
}

// Sets the wheels for the next tick, as docs/moving-robots.md describes the walk.
void CSwarmcensusRobot::Walk() {
    const CVector2 cObstacle = m_cObstacle();
    if (cObstacle.Length() >= m_fAvoidAbove && Abs(cObstacle.Angle()) < ToRadians(m_cAvoidWithin)) {
        m_unAvoiding = m_unAvoiding % 60 + 1;
        m_unLeft = 0;
        Drive(0.0, m_unAvoiding > 30 || cObstacle.GetY() > 0.0 ? -m_fTurnSpeed : m_fTurnSpeed);
        return;
    }
    m_unAvoiding = 0;
    Real fSpeed = 0.0, fTurn = 0.0;
    if (Steer(fSpeed, fTurn)) {
        fSpeed *= 100.0;                   // in cm a second
        fTurn *= 50.0 * m_fWheelDistance;  // of each wheel
        const Real fMost = std::abs(fSpeed) / m_fSpeed + std::abs(fTurn) / m_fTurnSpeed;
        m_unLeft = 0;
        Drive(fSpeed / std::max(fMost, 1.0), fTurn / std::max(fMost, 1.0));
        return;
    }
    if (m_unLeft == 0) {
        const bool bStraight = m_pcRNG->Bernoulli();
        const Real fTicks = bStraight ? std::floor(std::min(m_pcRNG->Exponential(m_fStraightMean), 1e6))
                                      : m_pcRNG->Uniform(CRange<UInt32>(0, m_unTurnMost + 1));
        m_fMoveSpeed = bStraight ? m_fSpeed : 0.0;
        m_fMoveTurn = bStraight || fTicks == 0.0 ? 0.0 : m_pcRNG->Bernoulli() ? m_fTurnSpeed : -m_fTurnSpeed;
        m_unLeft = std::max(UInt32(fTicks), UInt32(1));
    }
    --m_unLeft;
    Drive(m_fMoveSpeed, m_fMoveTurn);
}

// In cm a second: the speed, and how much faster the right wheel is and the left one slower.
void CSwarmcensusRobot::Drive(Real f_speed, Real f_turn) {
    m_pcWheels->SetLinearVelocity(f_speed - f_turn, f_speed + f_turn);
}
