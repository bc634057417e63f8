// Configures the bundled mock OpenXR runtime if the loader selects it. The mock runtime reads its
// environment variables when an instance is created.
#pragma once

#include <filesystem>
#include <string>

#include "app/trainer/attempt/staging.h"

namespace stylet::trainer {

// True if the loader would currently select the mock runtime.
bool isMockRuntimeSelected();

struct MockSettings {
    // Head motion script; empty: $XRMOCK_SCENARIO or, if unset, a head that leans over the path.
    std::filesystem::path scenario;
    bool virtual_clock = false;
    std::filesystem::path capture_dir;  // folder for captured pictures; empty: no captures
};

// Sets the environment variables of the mock runtime. Must exist as long as headset sessions may be created.
// Does nothing for other runtimes.
class MockStage {
  public:
    // Throws DataError if the script of the head motion cannot be written.
    MockStage(const MockSettings&, const Pose& stage_from_patient, const OperativeField&);
    ~MockStage();
    MockStage(const MockStage&) = delete;
    MockStage& operator=(const MockStage&) = delete;

  private:
    std::filesystem::path written_;
    bool scenario_set_ = false;
};

}  // namespace stylet::trainer
