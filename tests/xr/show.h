// Runs a session on the mock runtime with a scenario, and reads the runtime's log.
#pragma once

#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "painter.h"
#include "tests/support/temp_folder.h"

namespace stylet::xr {

class SessionTest : public testing::Test {
  protected:
    void SetUp() override;
    void TearDown() override;
    // Sets the fields of a version 2 scenario with a moving head and a controller in the right hand.
    void useScenario(const std::string& fields);
    void setVariable(const std::string& name, const std::string& value);
    // The log's entries: all, those of one call, or those of frames. Read them after the session was
    // destroyed.
    std::vector<nlohmann::json> log() const;
    std::vector<nlohmann::json> calls(const std::string& name) const;
    std::vector<nlohmann::json> frames() const;

    test::TempFolder folder_;

  private:
    std::vector<std::string> set_;
};

// A session and its painter. The painter outlives the session, because the painter's device owns the
// runtime's images.
struct Show {
    std::optional<Painter> painter;
    Session session;
    std::vector<SpaceChange> spaces;  // all changes that poll() reported
    News news;
    std::vector<ShownPanel> panels;

    explicit Show(const SessionSettings& settings = {
                      .passthrough = false, .stationary = true, .virtual_clock = true});
    // Runs one frame, and paints it if it should be rendered. `moment` captures its pictures under that
    // name.
    Frame frame(const std::string& moment = "");
    SessionPhase poll();
    bool reach(SessionPhase, int frames = 20);
    // Polls `frames` times. Runs a frame each time while the session is running.
    void run(int frames);
};

}  // namespace stylet::xr
