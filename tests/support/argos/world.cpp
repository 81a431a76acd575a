// Robots of the target argos in the stand-in's world: world TICKS RESET DATAGRAM ROUND_TICKS CONTROLLER...
// They meet in a square of 1 m and hear all others. Every second one is a Khepera IV.

#include <iostream>
#include <memory>

#include "argos.h"

using namespace argos;

struct CBody {
    std::unique_ptr<CCI_Controller> controller;
    CControllableEntity entity;
    CCI_DifferentialSteeringActuator wheels;
    CCI_RangeAndBearingActuator say;
    CCI_RangeAndBearingSensor hear;
    CCI_FootBotMotorGroundSensor ground;
    CCI_FootBotProximitySensor near;
    CCI_KheperaIVGroundSensor ground_of_khepera;
    CCI_KheperaIVProximitySensor near_of_khepera;
    CByteArray said;
    Real x = 0.0, y = 0.0, heading = 0.0;

    void Move() {
        said = say.data;
        const Real speed = (wheels.left + wheels.right) / 2000.0, turn = (wheels.right - wheels.left) / 140.0;
        x = std::min(std::max(x + speed * std::cos(heading), -0.5), 0.5);
        y = std::min(std::max(y + speed * std::sin(heading), -0.5), 0.5);
        heading += turn;
    }

    void Sense(CLoopFunctions& floor, const std::vector<std::unique_ptr<CBody>>& all) {
        ground.readings = ground_of_khepera.readings = {{floor.GetFloorColor({x, y}).grey}};
        near.readings.clear();
        for (int k = 0; k < 8; k++) {
            const Real angle = heading + k * M_PI / 4.0, ahead = 0.1;
            const bool beside = std::abs(x + ahead * std::cos(angle)) > 0.5;
            const bool wall = beside || std::abs(y + ahead * std::sin(angle)) > 0.5;
            near.readings.push_back({wall ? 1.0 : 0.0, {std::remainder(k * M_PI / 4.0, 2.0 * M_PI)}});
        }
        near_of_khepera.readings = near.readings;
        hear.readings.clear();
        for (const auto& other : all) {
            if (other.get() != this) {
                hear.readings.push_back({other->said});
            }
        }
    }
};

static int live(int ticks, int reset, size_t datagram, const std::string& round_ticks, char** labels, int robots) {
    std::vector<std::unique_ptr<CBody>> bodies;
    CSpace& space = CSimulator::GetInstance().space;
    for (int k = 0, trial = 0; k < robots; k += trial, trial = 1 - trial) {  // each is placed at the second trial
        if (trial == 0) {
            bodies.push_back(std::make_unique<CBody>());
        }
        CBody& body = *bodies.back();
        body.controller.reset();
        body.controller.reset(Registered<CCI_Controller>().at(labels[k])());
        CCI_Controller& controller = *body.controller;
        controller.id = labels[k] + std::to_string(k);
        body.heading = k;
        body.say.data = body.said = CByteArray(datagram);
        controller.actuators = {{"differential_steering", &body.wheels}, {"range_and_bearing", &body.say}};
        if (k % 2 == 0) {
            controller.sensors = {{"footbot_motor_ground", &body.ground}, {"footbot_proximity", &body.near}};
        } else {
            controller.sensors["kheperaiv_ground"] = &body.ground_of_khepera;
            controller.sensors["kheperaiv_proximity"] = &body.near_of_khepera;
        }
        controller.sensors["range_and_bearing"] = &body.hear;
        TConfigurationNode params{{"b", "0.9"}, {"w", "0.8"}, {"true_b", "0.95"}, {"round_ticks", round_ticks}};
        controller.Init(params);
        body.entity.controller = &controller;
        space.entities[controller.id] = &body.entity;
    }
    std::unique_ptr<CLoopFunctions> floor(Registered<CLoopFunctions>().at("swarmcensus_floor")());
    TConfigurationNode params{{"fill_ratio", "0.55"}, {"side", "1"}, {"logs", "day"}, {"result", "result.json"}};
    floor->Init(params);
    for (int tick = 1; tick <= ticks; tick++) {
        space.clock++;
        for (auto& body : bodies) {
            body->Move();
        }
        for (auto& body : bodies) {
            body->Sense(*floor, bodies);
            body->controller->ControlStep();
        }
        if (tick == reset) {
            space.clock = 0;
            for (auto& body : bodies) {
                body->controller->Reset();
                body->say.ClearData();
            }
            floor->Reset();
        }
    }
    floor->PostExperiment();
    return 0;
}

int main(int count, char** words) {
    try {
        return live(std::stoi(words[1]), std::stoi(words[2]), std::stoul(words[3]), words[4], words + 5, count - 5);
    } catch (const std::exception& error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
}
