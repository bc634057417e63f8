// A scenario, a session over the mock runtime, and what its log says afterwards.
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
    // The fields of a scenario of version 2, over a head that moves and a controller at the right.
    void useScenario(const std::string& fields);
    void setVariable(const std::string& name, const std::string& value);
    // Once the session is gone: every line, or those of a call, or those of frames.
    std::vector<nlohmann::json> log() const;
    std::vector<nlohmann::json> calls(const std::string& name) const;
    std::vector<nlohmann::json> frames() const;

    test::TempFolder folder_;

  private:
    std::vector<std::string> set_;
};

// A painter outlives its session: the runtime's images are the device's.
struct Show {
    std::optional<Painter> painter;
    Session session;
    std::vector<SpaceChange> spaces;  // the news that poll() brought, gathered
    News news;
    std::vector<ShownPanel> panels;

    explicit Show(const SessionSettings& settings = {
                      .passthrough = false, .stationary = true, .virtual_clock = true});
    // Makes a frame, painted when it is to be drawn.
    Frame frame(const std::string& moment = "");
    SessionPhase poll();
    bool reach(SessionPhase, int frames = 20);
    // Polls and makes frames as long as the session runs.
    void run(int frames);
};

}  // namespace stylet::xr
