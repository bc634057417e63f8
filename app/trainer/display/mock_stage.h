// Configures the bundled mock OpenXR runtime if the loader selects it. The mock runtime reads its
// environment variables when an instance is created.
#pragma once

#include <filesystem>
#include <string>

#include "app/trainer/attempt/staging.h"

namespace stylet::trainer {

// True if the loader would currently select the mock runtime.
bool mockRuntimeChosen();

struct MockSettings {
    std::filesystem::path scenario;  // empty: $XRMOCK_SCENARIO, or else a head that leans over the path
    bool virtual_clock = false;
    std::filesystem::path capture_dir;  // folder for captured pictures; empty: no captures
};

// Sets the environment variables of the mock runtime. Keep it alive as long as headset sessions may be
// created. Does nothing for any other runtime.
class MockStage {
  public:
    // Throws DataError if the script of the head motion cannot be written.
    MockStage(const MockSettings&, const Pose& stage_from_patient, const patient::PlannedPath&);
    ~MockStage();
    MockStage(const MockStage&) = delete;
    MockStage& operator=(const MockStage&) = delete;

  private:
    std::filesystem::path written_;
    bool scenario_set_ = false;
};

}  // namespace stylet::trainer
