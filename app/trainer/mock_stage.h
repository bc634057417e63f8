// What the bundled mock runtime is told, where it is the one that the loader takes. It reads its environment
// when an instance is made.
#pragma once

#include <filesystem>
#include <string>

#include "app/trainer/staging.h"

namespace stylet::trainer {

// True when the runtime that the loader would take now is the mock runtime.
bool mockRuntimeChosen();

struct MockSettings {
    std::filesystem::path scenario;  // empty: XRMOCK_SCENARIO's, or a head that leans over the path
    bool virtual_clock = false;
    std::filesystem::path capture_dir;  // of moments; empty: none
};

// For as long as headsets may be made; of no effect on any other runtime.
class MockStage {
  public:
    // Throws patient::DataError when the head's script cannot be written.
    MockStage(const MockSettings&, const patient::Pose& stage_from_patient, const patient::PlannedPath&);
    ~MockStage();
    MockStage(const MockStage&) = delete;
    MockStage& operator=(const MockStage&) = delete;

  private:
    std::filesystem::path written_;
    bool scenario_set_ = false;
};

}  // namespace stylet::trainer
