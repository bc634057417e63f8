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

constexpr std::size_t kMaxPendingReplies = 256;
constexpr std::size_t kMaxPendingEvents = 10'000;
const std::string kSource = "request";

JsonLine beginReply(const std::string& id, bool ok) {
    JsonLine line;
    line.open('{');
    if (!id.empty()) line.key("id").raw(id);
    line.key("ok").boolean(ok);
    return line;
}

void writeState(JsonLine& line, Instance& instance, std::int64_t now_ns) {
    constexpr const char* kLosses[] = {"none", "pending", "lost"};
    const Conditions& conditions = instance.conditions;
    line.fields("time", now_ns, "t_s", instance.clock.scenarioSeconds(now_ns), "frame",
                conditions.frames_waited);
    if (const Session* session = findSession(instance))
        line.fields("session_state", sessionStateName(session->progress.state), "running",
                    session->progress.running, "session_loss",
                    kLosses[static_cast<std::size_t>(session->loss)]);
    else
        line.fields("session_state", "none");
    line.fields("instance_loss", kLosses[static_cast<std::size_t>(conditions.loss)], "user_present",
                conditions.user_present, "refresh_hz", instance.scenario.refresh_hz, "paused",
                instance.lockstep.paused, "head", stageFromHead(instance, now_ns));
    line.key("eyes").open('[');
    for (const Pose& eye : stageFromEyes(instance, now_ns))
        line.pose(eye);
    line.close(']').fields("local", originAt(conditions.local, now_ns), "stage",
                           originAt(conditions.stage, now_ns));
    const Statistics& counts = instance.statistics;
    line.key("statistics")
        .object("submitted", counts.submitted, "discarded", counts.discarded, "missed", counts.missed,
                "captured", counts.captured, "haptic_pulses", counts.haptic_pulses, "refusals",
                counts.refusals);
}

std::string stateReply(Instance& instance, const std::string& id, std::int64_t now_ns) {
    JsonLine line = beginReply(id, true);
    writeState(line, instance, now_ns);
    return line.close('}').str();
}

std::string errorReply(const std::string& id, const std::string& reason) {
    return beginReply(id, false).key("error").text(reason).close('}').str();
}

void applyFragment(const Field& fragment, Instance& instance, std::int64_t now_ns) {
    fragment.requireObject({"head", "controllers", "hands", "session", "events"});
    if (instance.scenario.events.size() > kMaxPendingEvents) fragment.fail("too many events are pending");
    const ReadContext context{true, instance.clock.scenarioSeconds(now_ns), ""};
    Scenario tried;
    readTimelines(fragment, context, tried);  // a trial run: an invalid message must change nothing
    readTimelines(fragment, context, instance.scenario);
}

void parseWait(const Field& field, PendingReply& pending) {
    field.requireObject({"frame", "t_s", "session_state", "haptic_pulses"});
    if (field.value.size() != 1) field.fail("one condition expected");
    if (field.has("frame")) pending.frame = field.at("frame").integer(1, 1'000'000'000);
    if (field.has("t_s")) pending.t_s = field.at("t_s").number(0, kMaxNumber);
    if (field.has("haptic_pulses"))
        pending.haptic_pulses = field.at("haptic_pulses").integer(1, 1'000'000'000);
    if (field.has("session_state")) {
        pending.state = sessionStateNamed(field.at("session_state").text());
        if (!pending.state) field.at("session_state").fail("the name of a session state expected");
    }
}

// Returns whether there is room for another pending reply. If not, first drops the pending replies to
// disconnected clients.
bool hasRoomForReply(Instance& instance) {
    if (instance.pending_replies.size() < kMaxPendingReplies) return true;
    std::erase_if(instance.pending_replies, [&](const PendingReply& pending) {
        return instance.control && !instance.control->isConnected(pending.client);
    });
    return instance.pending_replies.size() < kMaxPendingReplies;
}

// Returns the reply, or "" if the reply is pending.
std::string serve(const Field& root, PendingReply pending, Instance& instance, std::int64_t now_ns) {
    root.requireObject({"id", "apply", "get", "pause", "step", "wait", "picture"});
    if (root.value.size() != (root.has("id") ? 2U : 1U)) root.fail("one request a line expected");
    if (root.has("apply")) {
        applyFragment(root.at("apply"), instance, now_ns);
        return beginReply(pending.id, true).close('}').str();
    }
    if (root.has("get")) {
        root.at("get").oneOf({"state"});
        return stateReply(instance, pending.id, now_ns);
    }
    if (root.has("pause")) {
        instance.lockstep = {root.at("pause").boolean(), 0};
        return beginReply(pending.id, true).close('}').str();
    }
    if (!hasRoomForReply(instance)) root.fail("too many requests are waiting");
    if (root.has("step")) {
        instance.lockstep.steps += root.at("step").integer(1, 1'000'000);
        instance.lockstep.paused = true;
        pending.steps = true;
    } else if (root.has("wait")) {
        parseWait(root.at("wait"), pending);
    } else {
        root.required("picture").requireObject({"eye"});
        pending.eye = root.at("picture").required("eye").oneOf({"left", "right"});
    }
    instance.pending_replies.push_back(std::move(pending));
    return {};
}

bool isConditionMet(const PendingReply& pending, Instance& instance, std::int64_t now_ns) {
    if (pending.frame) return instance.conditions.frames_waited >= *pending.frame;
    if (pending.t_s) return instance.clock.scenarioSeconds(now_ns) >= *pending.t_s;
    if (pending.haptic_pulses) return instance.statistics.haptic_pulses >= *pending.haptic_pulses;
    if (pending.state) {
        const Session* session = findSession(instance);
        return session != nullptr && session->progress.state == *pending.state;
    }
    return pending.steps && !instance.lockstep.paused;
}

void sendDueReplies(Instance& instance, std::int64_t now_ns, bool steps_done) {
    std::erase_if(instance.pending_replies, [&](const PendingReply& pending) {
        if (!(pending.steps && steps_done) && !isConditionMet(pending, instance, now_ns)) return false;
        if (instance.control)
            instance.control->reply(pending.client, stateReply(instance, pending.id, now_ns));
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
std::string parseId(const Field& root) {
    root.requireObject();
    if (!root.has("id")) return {};
    const Field id = root.at("id");
    if (id.value.is_number_integer() || (id.value.is_string() && id.text().size() <= 64))
        return id.value.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
    id.fail("a whole number or at most 64 bytes expected");
}

}  // namespace

void openControl(Instance& instance) {
    const char* path = std::getenv("XRMOCK_CONTROL");
    if (path != nullptr && *path != '\0') instance.control = std::make_unique<Control>(path);
}

std::string serveRequest(Instance& instance, std::uint64_t client, const std::string& line,
                         std::int64_t now_ns) {
    PendingReply pending;
    pending.client = client;
    try {
        const nlohmann::json document = parseJson(line, kSource);
        const Field root{document, kSource, ""};
        pending.id = parseId(root);
        return serve(root, pending, instance, now_ns);
    } catch (const FieldError& error) {
        return errorReply(pending.id, error.what());
    }
}

void serveControl(Instance& instance, std::int64_t now_ns) {
    if (!instance.control) return;
    for (const Control::Request& request : instance.control->popRequests()) {
        const std::string reply = serveRequest(instance, request.client, request.line, now_ns);
        if (!reply.empty()) instance.control->reply(request.client, reply);
    }
    sendDueReplies(instance, now_ns, false);
}

bool mayProceed(Instance& instance, std::int64_t now_ns) {
    if (!instance.lockstep.paused) return true;
    if (instance.lockstep.steps > 0) {
        --instance.lockstep.steps;
        return true;
    }
    sendDueReplies(instance, now_ns, true);
    return false;
}

void sendPictures(Call& call, Session& session, const SubmittedFrame& frame) {
    Instance& instance = session.instance;
    std::array<std::string, 2> pngs;  // compose each eye only once, for all clients
    for (const PendingReply& pending : instance.pending_replies) {
        if (!pending.eye) continue;
        std::string reply;
        try {
            std::string& png = pngs.at(*pending.eye);
            if (png.empty()) png = eyePng(call, session, frame, *pending.eye);
            JsonLine line = beginReply(pending.id, true);
            reply = line.fields("frame", frame.number, "png", base64(png)).close('}').str();
        } catch (const Refused& refused) {
            reply = errorReply(pending.id, "picture: " + refused.reason);
        } catch (const std::exception& error) {
            reply = errorReply(pending.id, std::string("picture: ") + error.what());
        }
        if (instance.control) instance.control->reply(pending.client, reply);
    }
    std::erase_if(instance.pending_replies,
                  [](const PendingReply& pending) { return pending.eye.has_value(); });
}

}  // namespace xrmock
