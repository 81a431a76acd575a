// Loop functions: a floor of tiles that are black with a probability, logs of all robots, and a file with the result.

#include <argos3/core/simulator/entity/controllable_entity.h>
#include <argos3/core/simulator/loop_functions.h>
#include <argos3/core/simulator/simulator.h>
#include <argos3/core/simulator/space/space.h>
#include <argos3/core/utility/math/rng.h>
#include <argos3/core/utility/math/vector2.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "swarmcensus_robot.h"

using namespace argos;

class CSwarmcensusFloor : public CLoopFunctions {
  public:
    void Init(TConfigurationNode& t_tree) override {
        GetNodeAttribute(t_tree, "fill_ratio", m_fFillRatio);
        GetNodeAttribute(t_tree, "side", m_fSide);
        GetNodeAttributeOrDefault(t_tree, "tile", m_fTile, m_fTile);
        GetNodeAttributeOrDefault(t_tree, "logs", m_strLogs, m_strLogs);
        GetNodeAttributeOrDefault(t_tree, "result", m_strResult, m_strResult);
        if (!(m_fFillRatio >= 0.0 && m_fFillRatio <= 1.0) || !(m_fTile > 0.0) || !(m_fSide > 0.0)) {
            THROW_ARGOSEXCEPTION("fill_ratio should be from 0 to 1, side and tile above 0");
        }
        if (!(m_fSide / m_fTile <= 20'000.0)) {
            THROW_ARGOSEXCEPTION("side=\"" << m_fSide << "\" tile=\"" << m_fTile << "\": at most 20,000 tiles in a row");
        }
        m_pcRNG = CRandom::CreateRNG("argos");
        m_unTiles = 2 * size_t(std::ceil(m_fSide / 2.0 / m_fTile));
        Paint();
        if (!m_strResult.empty()) {
            Write(m_strResult);  // now, so that one that cannot be written is known before the run
        }
        if (!m_strLogs.empty()) {
            std::filesystem::create_directories(m_strLogs);
            for (const auto& cEntry : std::filesystem::directory_iterator(m_strLogs)) {
                if (cEntry.path().extension() == ".log") {
                    THROW_ARGOSEXCEPTION("logs=\"" << m_strLogs << "\": it holds " << cEntry.path().filename()
                                                   << " of another run: should be a new folder");
                }
            }
            for (CSwarmcensusRobot* pcRobot : Robots()) {
                pcRobot->Record(m_strLogs, 1.0 / CPhysicsEngine::GetSimulationClockTick());
                const std::string strFile = pcRobot->Label().File;
                std::filesystem::copy_file(std::string(SWARMCENSUS_BRAINS) + "/" + strFile, m_strLogs + "/" + strFile,
                                           std::filesystem::copy_options::overwrite_existing);
            }
            Write(m_strLogs + "/swarm.json");
        }
    }

    void Reset() override { Paint(); }

    CColor GetFloorColor(const CVector2& c_position) override {
        const Real fHalf = Real(m_unTiles / 2);
        const Real fColumn = std::floor(c_position.GetX() / m_fTile) + fHalf;
        const Real fRow = std::floor(c_position.GetY() / m_fTile) + fHalf;
        if (fColumn < 0.0 || fRow < 0.0 || fColumn >= m_unTiles || fRow >= m_unTiles) {
            return CColor::WHITE;
        }
        return m_vecBlack[size_t(fRow) * m_unTiles + size_t(fColumn)] ? CColor::BLACK : CColor::WHITE;
    }

    void PostExperiment() override {
        if (!m_strLogs.empty()) {
            Write(m_strLogs + "/swarm.json");
        }
        if (!m_strResult.empty()) {
            Write(m_strResult);
        }
    }

  private:
    void Paint() {
        m_vecBlack.resize(m_unTiles * m_unTiles);
        m_unBlack = 0;
        for (size_t k = 0; k < m_vecBlack.size(); ++k) {
            m_vecBlack[k] = m_pcRNG->Bernoulli(m_fFillRatio);
            m_unBlack += m_vecBlack[k];
        }
    }

    std::vector<CSwarmcensusRobot*> Robots() {
        std::vector<CSwarmcensusRobot*> vecRobots;
        for (const auto& [strId, cEntity] : GetSpace().GetEntitiesByType("controller")) {
            auto& cController = any_cast<CControllableEntity*>(cEntity)->GetController();
            if (auto* pcRobot = dynamic_cast<CSwarmcensusRobot*>(&cController)) {
                vecRobots.push_back(pcRobot);
            }
        }
        return vecRobots;
    }

    // What `swarmcensus relive` asks of a folder of logs, and what the robots believe.
    void Write(const std::string& str_file) {
        std::ofstream cOut(str_file);
        cOut.precision(17);
        const auto vecRobots = Robots();
        if (vecRobots.empty()) {
            THROW_ARGOSEXCEPTION("no robot has a controller of swarmcensus");
        }
        const SBrainLabel& sLabel = vecRobots[0]->Label();
        const UInt32 unTicks = GetSpace().GetSimulationClock();
        cOut << "{\n \"format\": 1,\n \"title\": \"ARGoS\",\n \"brain\": {\"file\": \"" << sLabel.File
             << "\", \"name\": " << sLabel.Name << ", \"parameters\": " << sLabel.Parameters
             << "},\n \"message\": " << sLabel.Message << ",\n \"precision\": " << sLabel.Precision
             << ",\n \"fill_ratio\": " << m_fFillRatio << ",\n \"floor\": " << Real(m_unBlack) / m_vecBlack.size()
             << ",\n \"seed\": " << CSimulator::GetInstance().GetRandomSeed() << ",\n \"ticks\": " << unTicks
             << ",\n \"rounds\": " << unTicks / vecRobots[0]->RoundTicks() << ",\n \"robots\": [";
        const char* pchBefore = "\n";
        for (CSwarmcensusRobot* pcRobot : vecRobots) {
            cOut << pchBefore << "  {\"number\": " << pcRobot->Number() << ", \"log\": \"robot-" << pcRobot->Number()
                 << ".log\", \"id\": \"" << pcRobot->GetId() << "\", \"brain\": \"" << pcRobot->Label().File
                 << "\", \"b\": " << pcRobot->B() << ", \"w\": " << pcRobot->W() << ", \"estimate\": "
                 << pcRobot->Estimate() << ", \"read\": " << pcRobot->Read() << ", \"heard\": " << pcRobot->Heard()
                 << "}";
            pchBefore = ",\n";
        }
        cOut << "\n ]\n}\n";
        if (!cOut) {
            THROW_ARGOSEXCEPTION("cannot write " << str_file);
        }
    }

    CRandom::CRNG* m_pcRNG = nullptr;
    Real m_fFillRatio = 0.0, m_fSide = 0.0, m_fTile = 0.01;  // metres
    size_t m_unTiles = 0, m_unBlack = 0;                     // in a row; all that are black
    std::vector<bool> m_vecBlack;
    std::string m_strLogs, m_strResult;  // nothing is written if empty
};

REGISTER_LOOP_FUNCTIONS(CSwarmcensusFloor, "swarmcensus_floor")
