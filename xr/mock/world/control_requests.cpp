#include "world/control_requests.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "control/control.h"
#include "scenario/json_line.h"
#include "scenario/names.h"
#include "scenario/scenario.h"
#include "world/call.h"
#include "world/capture.h"
#include "world/objects.h"
#include "world/spaces.h"

namespace xrmock {

namespace {

constexpr std::size_t kMaxPromises = 256;
constexpr std::size_t kMaxPendingEvents = 10'000;
const std::string kSource = "request";

Session* sessionOf(Instance& instance) {
    for (Object* child : instance.children) {
        if (child->type == XR_OBJECT_TYPE_SESSION) return static_cast<Session*>(child);
    }
    return nullptr;
}

JsonLine beginReply(const std::string& id, bool ok) {
    JsonLine line;
    line.open('{');
    if (!id.empty()) line.key("id").raw(id);
    line.key("ok").boolean(ok);
    return line;
}

void tellCounts(JsonLine& line, const Statistics& counts) {
    line.key("statistics").open('{').key("submitted").number(counts.submitted);
    line.key("discarded").number(counts.discarded).key("missed").number(counts.missed);
    line.key("captured").number(counts.captured).key("haptic_pulses").number(counts.haptic_pulses);
    line.key("refusals").number(counts.refusals).close('}');
}

void tellState(JsonLine& line, Instance& instance, std::int64_t now_ns) {
    constexpr const char* kLosses[] = {"none", "pending", "lost"};
    const Conditions& conditions = instance.conditions;
    line.key("time").number(now_ns).key("t_s").number(instance.clock.scenarioSeconds(now_ns));
    line.key("frame").number(conditions.frames_waited);
    if (const Session* session = sessionOf(instance)) {
        line.key("session_state").text(sessionStateName(session->progress.state));
        line.key("running").boolean(session->progress.running);
        line.key("session_loss").text(kLosses[static_cast<std::size_t>(session->loss)]);
    } else {
        line.key("session_state").text("none");
    }
    line.key("instance_loss").text(kLosses[static_cast<std::size_t>(conditions.loss)]);
    line.key("user_present").boolean(conditions.user_present);
    line.key("refresh_hz")
        .number(instance.scenario.refresh_hz)
        .key("paused")
        .boolean(instance.lockstep.paused);
    line.key("head").pose(stageFromHead(instance, now_ns)).key("eyes").open('[');
    for (const Pose& eye : stageFromEyes(instance, now_ns))
        line.pose(eye);
    line.close(']').key("local").pose(originAt(conditions.local, now_ns));
    line.key("stage").pose(originAt(conditions.stage, now_ns));
    tellCounts(line, instance.statistics);
}

std::string stateReply(Instance& instance, const std::string& id, std::int64_t now_ns) {
    JsonLine line = beginReply(id, true);
    tellState(line, instance, now_ns);
    return line.close('}').str();
}

std::string errorReply(const std::string& id, const std::string& reason) {
    return beginReply(id, false).key("error").text(reason).close('}').str();
}

void applyFragment(const Field& fragment, Instance& instance, std::int64_t now_ns) {
    fragment.objectOf({"head", "controllers", "hands", "session", "events"});
    if (instance.scenario.events.size() > kMaxPendingEvents) fragment.fail("too many events are pending");
    const Reading reading{true, instance.clock.scenarioSeconds(now_ns), ""};
    Scenario tried;
    readTimelines(fragment, reading, tried);  // parse all of it first: a bad message changes nothing
    readTimelines(fragment, reading, instance.scenario);
}

void parseWait(const Field& field, Promise& promise) {
    field.objectOf({"frame", "t_s", "session_state", "haptic_pulses"});
    if (field.value.size() != 1) field.fail("one condition expected");
    if (field.has("frame")) promise.frame = field.at("frame").integer(1, 1'000'000'000);
    if (field.has("t_s")) promise.t_s = field.at("t_s").number(0, kMaxNumber);
    if (field.has("haptic_pulses")) {
        promise.haptic_pulses = field.at("haptic_pulses").integer(1, 1'000'000'000);
    }
    if (field.has("session_state")) {
        promise.state = sessionStateNamed(field.at("session_state").text());
        if (!promise.state) field.at("session_state").fail("the name of a session state expected");
    }
}

// Returns whether another reply may be pending. Pending replies to disconnected clients are dropped first
// if there are too many.
bool mayPromise(Instance& instance) {
    if (instance.promises.size() < kMaxPromises) return true;
    std::erase_if(instance.promises, [&](const Promise& promise) {
        return instance.control && !instance.control->isConnected(promise.client);
    });
    return instance.promises.size() < kMaxPromises;
}

// Returns the reply, or "" if the reply is pending.
std::string serve(const Field& root, Promise promise, Instance& instance, std::int64_t now_ns) {
    root.objectOf({"id", "apply", "get", "pause", "step", "wait", "picture"});
    if (root.value.size() != (root.has("id") ? 2U : 1U)) root.fail("one request a line expected");
    if (root.has("apply")) {
        applyFragment(root.at("apply"), instance, now_ns);
        return beginReply(promise.id, true).close('}').str();
    }
    if (root.has("get")) {
        root.at("get").oneOf({"state"});
        return stateReply(instance, promise.id, now_ns);
    }
    if (root.has("pause")) {
        instance.lockstep = {root.at("pause").boolean(), 0};
        return beginReply(promise.id, true).close('}').str();
    }
    if (!mayPromise(instance)) root.fail("too many requests are waiting");
    if (root.has("step")) {
        instance.lockstep.steps += root.at("step").integer(1, 1'000'000);
        instance.lockstep.paused = true;
        promise.steps = true;
    } else if (root.has("wait")) {
        parseWait(root.at("wait"), promise);
    } else {
        root.required("picture").objectOf({"eye"});
        promise.eye = root.at("picture").required("eye").oneOf({"left", "right"});
    }
    instance.promises.push_back(std::move(promise));
    return {};
}

bool isKept(const Promise& promise, Instance& instance, std::int64_t now_ns) {
    if (promise.frame) return instance.conditions.frames_waited >= *promise.frame;
    if (promise.t_s) return instance.clock.scenarioSeconds(now_ns) >= *promise.t_s;
    if (promise.haptic_pulses) return instance.statistics.haptic_pulses >= *promise.haptic_pulses;
    if (promise.state) {
        const Session* session = sessionOf(instance);
        return session != nullptr && session->progress.state == *promise.state;
    }
    return promise.steps && !instance.lockstep.paused;
}

void keepPromises(Instance& instance, std::int64_t now_ns, bool steps_done) {
    std::erase_if(instance.promises, [&](const Promise& promise) {
        if (!(promise.steps && steps_done) && !isKept(promise, instance, now_ns)) return false;
        if (instance.control)
            instance.control->reply(promise.client, stateReply(instance, promise.id, now_ns));
        return true;
    });
}

std::string base64(const std::string& bytes) {
    constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t three = 0;
        for (std::size_t j = 0; j < 3; ++j)
            three = three << 8 | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0U);
        for (std::size_t j = 0; j < 4; ++j)
            text += i + j <= bytes.size() ? kDigits[three >> (18 - 6 * j) & 63] : '=';
    }
    return text;
}

// Returns the id as JSON: an integer or a short string; empty if missing.
std::string idOf(const Field& root) {
    root.object();
    if (!root.has("id")) return {};
    const Field id = root.at("id");
    if (id.value.is_number_integer() || (id.value.is_string() && id.text().size() <= 64)) {
        return id.value.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
    }
    id.fail("a whole number or at most 64 bytes expected");
}

}  // namespace

void openControl(Instance& instance) {
    const char* path = std::getenv("XRMOCK_CONTROL");
    if (path != nullptr && *path != '\0') instance.control = std::make_unique<Control>(path);
}

std::string serveRequest(Instance& instance, std::uint64_t client, const std::string& line,
                         std::int64_t now_ns) {
    Promise promise;
    promise.client = client;
    try {
        const nlohmann::json document = parseJson(line, kSource);
        const Field root{document, kSource, ""};
        promise.id = idOf(root);
        return serve(root, promise, instance, now_ns);
    } catch (const FieldError& error) {
        return errorReply(promise.id, error.what());
    }
}

void serveControl(Instance& instance, std::int64_t now_ns) {
    if (!instance.control) return;
    for (const Control::Request& request : instance.control->takeRequests()) {
        const std::string reply = serveRequest(instance, request.client, request.line, now_ns);
        if (!reply.empty()) instance.control->reply(request.client, reply);
    }
    keepPromises(instance, now_ns, false);
}

bool mayGoOn(Instance& instance, std::int64_t now_ns) {
    if (!instance.lockstep.paused) return true;
    if (instance.lockstep.steps > 0) {
        --instance.lockstep.steps;
        return true;
    }
    keepPromises(instance, now_ns, true);
    return false;
}

void servePictures(Call& call, Session& session, const SubmittedFrame& frame) {
    Instance& instance = session.instance;
    std::array<std::string, 2> pngs;  // compose each eye only once, for all clients
    for (const Promise& promise : instance.promises) {
        if (!promise.eye) continue;
        std::string reply;
        try {
            std::string& png = pngs.at(*promise.eye);
            if (png.empty()) png = eyePng(call, session, frame, *promise.eye);
            reply = beginReply(promise.id, true)
                        .key("frame")
                        .number(frame.number)
                        .key("png")
                        .text(base64(png))
                        .close('}')
                        .str();
        } catch (const Refused& refused) {
            reply = errorReply(promise.id, "picture: " + refused.reason);
        } catch (const std::exception& error) {
            reply = errorReply(promise.id, std::string("picture: ") + error.what());
        }
        if (instance.control) instance.control->reply(promise.client, reply);
    }
    std::erase_if(instance.promises, [](const Promise& promise) { return promise.eye.has_value(); });
}

}  // namespace xrmock
