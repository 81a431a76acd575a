// A robot in ARGoS 3 around any brain: a foot-bot or a Khepera IV that walks at random, reads tiles and talks.

#ifndef SWARMCENSUS_ROBOT_H
#define SWARMCENSUS_ROBOT_H

#include <argos3/core/control_interface/ci_controller.h>
#include <argos3/core/utility/math/rng.h>
#include <argos3/core/utility/math/vector2.h>
#include <argos3/plugins/robots/generic/control_interface/ci_differential_steering_actuator.h>
#include <argos3/plugins/robots/generic/control_interface/ci_range_and_bearing_actuator.h>
#include <argos3/plugins/robots/generic/control_interface/ci_range_and_bearing_sensor.h>

#include <functional>
#include <string>

// What logs say of a brain: the file of its source, and texts of JSON. Parameters are those that differ from the file.
struct SBrainLabel {
    std::string File, Name, Parameters, Message, Precision;
};

class CSwarmcensusRobot : public argos::CCI_Controller {
  public:
    ~CSwarmcensusRobot() override;
    void Init(argos::TConfigurationNode& t_tree) override;
    void ControlStep() override;
    void Reset() override;

    // From now on write a log into a folder.
    void Record(const std::string& str_folder, argos::Real f_ticks_per_second);

    argos::UInt16 Number() const { return m_unNumber; }
    argos::UInt32 RoundTicks() const { return m_unRoundTicks; }
    argos::Real B() const { return m_fB; }
    argos::Real W() const { return m_fW; }
    argos::Real Estimate() const { return m_fEstimate; }
    argos::UInt32 Read() const { return m_unRead; }    // readings so far
    argos::UInt32 Heard() const { return m_unHeard; }  // messages so far
    virtual const SBrainLabel& Label() const = 0;

  protected:
    argos::CRandom::CRNG* m_pcRNG = nullptr;

    // What each brain does; in a round in this order.
    virtual size_t DatagramBytes() const = 0;
    virtual void Start() = 0;
    virtual void OpenLog(const std::string& str_file, argos::UInt32 un_period) = 0;
    virtual bool IsDone() const = 0;
    virtual void Observe(argos::UInt16 un_blacks, argos::UInt16 un_looks) = 0;
    virtual bool Say(argos::UInt8* pun_datagram) = 0;
    virtual bool Hear(const argos::UInt8* pun_datagram) = 0;
    virtual argos::Real End(argos::UInt32 un_milliseconds) = 0;
    virtual bool Steer(argos::Real& f_speed, argos::Real& f_turn) const = 0;  // metres and radians a second

  private:
    template <class GROUND, class PROXIMITY>
    void Use(const std::string& str_ground, const std::string& str_proximity, argos::Real f_wheel_distance);
    void Begin();
    void Look();
    void Round();
    void Walk();
    void Drive(argos::Real f_speed, argos::Real f_turn);

    argos::CCI_DifferentialSteeringActuator* m_pcWheels = nullptr;
    argos::CCI_RangeAndBearingActuator* m_pcSay = nullptr;
    argos::CCI_RangeAndBearingSensor* m_pcHear = nullptr;
    std::function<argos::Real()> m_cGround;        // of the sensor at the front left: 0 black, 1 white
    std::function<argos::CVector2()> m_cObstacle;  // the mean of the proximity ring's readings

    // from <params>
    argos::Real m_fB = 0.0, m_fW = 0.0, m_fTrueB = 0.0, m_fTrueW = 0.0, m_fThreshold = 0.5;
    argos::Real m_fSpeed = 14.0, m_fTurnSpeed = 14.0, m_fStraightMean = 15.0, m_fAvoidAbove = 0.01;
    argos::CDegrees m_cAvoidWithin = argos::CDegrees(100.0);
    argos::UInt32 m_unRoundTicks = 1, m_unTurnMost = 10;

    argos::Real m_fWheelDistance = 0.0, m_fTicksPerSecond = 10.0, m_fEstimate = 0.5;
    argos::UInt16 m_unNumber = 0;  // which no other robot has
    std::string m_strLogs;         // the folder; none if empty
    argos::UInt32 m_unStep = 0, m_unRead = 0, m_unHeard = 0;
    argos::UInt16 m_unBlacks = 0, m_unLooks = 0;   // in this round
    argos::UInt32 m_unAvoiding = 0, m_unLeft = 0;  // ticks of avoiding in a row; ticks left of a move
    argos::Real m_fMoveSpeed = 0.0, m_fMoveTurn = 0.0;
};

#endif
