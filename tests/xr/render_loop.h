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
    // Adds these fields to a version 2 scenario with a moving head. Until this is called, the scenario has a
    // controller in the right hand.
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
struct RenderLoop {
    std::optional<Painter> painter;
    Session session;
    std::vector<SpaceChange> spaces;  // all changes that poll() reported
    SessionEvents events;
    std::vector<ShownPanel> panels;

    explicit RenderLoop(const SessionSettings& settings = {
                            .passthrough = false, .stationary = true, .virtual_clock = true});
    // Runs one frame, and paints it if it should be rendered. If `capture` is set, captures its pictures
    // under that name.
    Frame frame(const std::string& capture = "");
    SessionPhase poll();
    bool runUntil(SessionPhase, int frames = 20);
    // Polls `frames` times. After each poll, runs a frame if the session is running.
    void run(int frames);
};

}  // namespace stylet::xr
