// The controller of robots with the brain ${brain}.

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

namespace brain_${own} {  // before ARGoS, so that its macros do not meet the names of the brain
#include "${name}_brain.h"
#include "${name}_logged.h"
#define MARK 0x${mark}  // of brain and format
#define LUCK ${luck}  // whether the brain uses luck
#define NAMED ${named}  // whether the brain uses the robot's name
#define ENDS ${ends}  // whether it is done at some time, and then makes no more readings
#define STEERS ${steers}  // whether it sets the robot's course
#define ROBOT_SENDERS 200  // of whom the last message is known
#include "robot.h"
#include "robot_log.h"
}  // namespace brain_${own}

#include "swarmcensus_robot.h"

using namespace argos;

namespace brain_${own} {

static const bool IS_SECOND = CFactory<CCI_Controller>::Exists("${name}");  // of this name, in another library
static const uint8_t WHOLE_MARK[4] = {${whole_mark}};  // after each datagram: MARK is its first byte

struct thinker : robot {
    robot_log log = {};
    CRandom::CRNG *chance = nullptr;
};

#if LUCK
static number robot_draw(robot *robot) {
    auto *thinker = static_cast<struct thinker *>(robot);
    const UInt32 bits = sizeof(number) == 8 ? 31 : 23;  // so that none is rounded to 1
    const UInt32 drawn = thinker->chance->Uniform(CRange<UInt32>(0, UInt32(1) << bits));
    const number x = (number(drawn) + number(0.5)) / number(UInt32(1) << bits);
    robot_log_drew(&thinker->log, x);
    return x;
}
#endif

}  // namespace brain_${own}

class CSwarmcensus_${own} : public CSwarmcensusRobot {
  public:
    ~CSwarmcensus_${own}() override { Close(); }

    const SBrainLabel& Label() const override {
        static const SBrainLabel sLabel = {"${name}.py", ${label}};
        return sLabel;
    }

  protected:
    size_t DatagramBytes() const override { return ROBOT_DATAGRAM + 4; }

    void Start() override {
        if (brain_${own}::IS_SECOND) {
            THROW_ARGOSEXCEPTION("two libraries have a controller \"${name}\": give one brain's file another name");
        }
        m_sRobot.chance = m_pcRNG;
        robot_start(&m_sRobot, brain_${own}::number(B()), brain_${own}::number(W()), Number(), 1);
    }

    void OpenLog(const std::string& str_file, UInt32 un_period) override {
        Close();
        robot_log_open(&m_sRobot.log, str_file.c_str(), &m_sRobot, un_period, 0);
        if (!m_sRobot.log.file) {
            THROW_ARGOSEXCEPTION("cannot write " << str_file);
        }
    }

    bool IsDone() const override { return m_sRobot.is_done; }

    void Observe(UInt16 un_blacks, UInt16 un_looks) override {
        robot_observe(&m_sRobot, un_blacks, un_looks);
        robot_log_read(&m_sRobot.log, un_blacks, un_looks);
    }

    bool Say(UInt8* pun_datagram) override {
        const bool says = robot_say(&m_sRobot, pun_datagram);
        if (says) {
            memcpy(pun_datagram + ROBOT_DATAGRAM, brain_${own}::WHOLE_MARK, 4);
            robot_log_said(&m_sRobot.log, pun_datagram);
        }
        return says;
    }

    bool Hear(const UInt8* pun_datagram) override {
        const bool is_ours = memcmp(pun_datagram + ROBOT_DATAGRAM, brain_${own}::WHOLE_MARK, 4) == 0;
        const bool hears = is_ours && m_sRobot.log.heard < ROBOT_LOG_HEARD && robot_hear(&m_sRobot, pun_datagram);
        if (hears) {
            robot_log_heard(&m_sRobot.log, pun_datagram);
        }
        return hears;
    }

    Real End(UInt32 un_milliseconds) override {
        const brain_${own}::number x = robot_end(&m_sRobot);
        robot_log_tick(&m_sRobot.log, &m_sRobot, un_milliseconds, x);
        return x;
    }

    bool Steer(Real& f_speed, Real& f_turn) const override {
#if STEERS
        f_speed = m_sRobot.course.speed;
        f_turn = m_sRobot.course.turn;
        return m_sRobot.is_steered;
#else
        return (void)f_speed, (void)f_turn, false;
#endif
    }

  private:
    void Close() {
        if (m_sRobot.log.file) {
            fclose(m_sRobot.log.file);
        }
    }

    brain_${own}::thinker m_sRobot;
};

REGISTER_CONTROLLER(CSwarmcensus_${own}, "${name}")
