#include "render_loop.h"

#include <cstdlib>

namespace stylet::xr {
namespace {

constexpr const char* kCommon = R"({"version": 2, "refresh_hz": 100,
  "eyes": {"ipd_m": 0.06, "recommended_size": [64, 48], "lens": {"radius": 0.7},
           "left_fov_rad": [-0.9, 0.7, 0.8, -0.75], "right_fov_rad": [-0.7, 0.9, 0.8, -0.75]},
  "head": [{"t_s": 0, "position": [0, 1.5, 0]}, {"t_s": 10, "position": [1, 1.5, 0]}])";
constexpr const char* kRightController = R"("controllers": {"right":
    {"poses": [{"t_s": 0, "position": [0.25, 1.25, -0.5]}], "values": [{"t_s": 1.1, "select/click": true}]}})";

}  // namespace

void SessionTest::SetUp() {
    setVariable("XR_RUNTIME_JSON", STYLET_MOCK_MANIFEST);
    setVariable("XRMOCK_CLOCK", "virtual");
    setVariable("XRMOCK_CAPTURE", folder_.path());
    setVariable("XRMOCK_LOG", folder_ / "log.jsonl");
    useScenario(kRightController);
}

void SessionTest::TearDown() {
    for (const std::string& name : set_)
        unsetenv(name.c_str());
}

void SessionTest::setVariable(const std::string& name, const std::string& value) {
    setenv(name.c_str(), value.c_str(), 1);
    set_.push_back(name);
}

void SessionTest::useScenario(const std::string& fields) {
    std::ofstream(folder_ / "scenario.json") << kCommon << (fields.empty() ? "" : ",") << fields << "}";
    setVariable("XRMOCK_SCENARIO", folder_ / "scenario.json");
}

std::vector<nlohmann::json> SessionTest::log() const {
    std::vector<nlohmann::json> lines;
    std::ifstream in(folder_ / "log.jsonl");
    for (std::string line; std::getline(in, line);)
        lines.push_back(nlohmann::json::parse(line));
    return lines;
}

std::vector<nlohmann::json> SessionTest::calls(const std::string& name) const {
    std::vector<nlohmann::json> found;
    for (nlohmann::json& line : log())
        if (line.value("call", "") == name) found.push_back(std::move(line));
    return found;
}

std::vector<nlohmann::json> SessionTest::frames() const {
    std::vector<nlohmann::json> found;
    for (nlohmann::json& line : log())
        if (line.contains("frame")) found.push_back(std::move(line));
    return found;
}

RenderLoop::RenderLoop(const SessionSettings& settings) : session("Stylet test", settings) {
    painter.emplace(session);
    painter->start();
}

Frame RenderLoop::frame(const std::string& capture) {
    const Frame made = session.beginFrame();
    if (made.should_render) {
        painter->paint(made.image, {{{1, 0, 0, 1}, {0, 0, 1, 1}}});
        if (made.depth_image) painter->clearDepth(made.depth_image, 0.5f);
    }
    if (!capture.empty()) session.markCapture(capture);
    session.endFrame(made, panels);
    return made;
}

SessionPhase RenderLoop::poll() {
    const SessionPhase phase = session.poll();
    SessionEvents latest = session.popEvents();
    spaces.insert(spaces.end(), latest.spaces.begin(), latest.spaces.end());
    for (std::size_t eye = 0; eye < 2; ++eye)
        events.hidden_area_changed[eye] |= latest.hidden_area_changed[eye];
    events.profiles_changed |= latest.profiles_changed;
    if (latest.worn) events.worn = latest.worn;
    return phase;
}

bool RenderLoop::runUntil(SessionPhase phase, int frames) {
    for (int i = 0; i < frames; ++i) {
        if (poll() == phase) return true;
        if (session.running()) frame();
    }
    return false;
}

void RenderLoop::run(int frames) {
    for (int i = 0; i < frames; ++i) {
        poll();
        if (session.running()) frame();
    }
}

}  // namespace stylet::xr
