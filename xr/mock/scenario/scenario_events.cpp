#include "scenario/scenario_events.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenario/names.h"
#include "scenario/profiles.h"

namespace xrmock {

namespace {

constexpr char kCapturePrefix[] = "capture:";
constexpr std::size_t kMaxCaptureName = 128;

constexpr double kMaxDelay_s = 3600;
constexpr std::size_t kMaxEvents = 10'000;

Recentring parseRecentring(const Field& field) {
    field.requireObject({"space", "pose", "pose_valid", "delay_s"});
    Recentring recentring;
    constexpr XrReferenceSpaceType kSpaces[] = {XR_REFERENCE_SPACE_TYPE_LOCAL, XR_REFERENCE_SPACE_TYPE_STAGE,
                                                XR_REFERENCE_SPACE_TYPE_STATIONARY_EXT};
    if (field.has("space"))
        recentring.space = kSpaces[field.at("space").oneOf({"local", "stage", "stationary"})];
    if (field.has("pose")) {
        field.at("pose").requireObject({"position", "orientation"});
        recentring.room_from_origin = parsePose(field.at("pose"));
    }
    if (field.has("pose_valid")) recentring.pose_valid = field.at("pose_valid").boolean();
    if (field.has("delay_s")) recentring.delay_s = field.at("delay_s").number(0, kMaxDelay_s);
    return recentring;
}

MaskChange parseMaskChange(const Field& field) {
    field.requireObject({"lens"});
    if (!field.has("lens")) return {};
    return {parseLens(field.at("lens"))};
}

ProfileChange parseProfileChange(const Field& field) {
    const std::string profile = field.text();
    const Profile* found = findProfile(profile);
    if (found == nullptr) field.fail("not an interaction profile");
    if (findComponents(*found, User::left_hand).empty()) field.fail("not a profile of hands");
    return {profile};
}

SessionLoss parseSessionLoss(const Field& field) {
    field.requireObject({"lost_after_s"});
    if (!field.has("lost_after_s")) return {};
    return {field.at("lost_after_s").number(0, kMaxDelay_s)};
}

InstanceLoss parseInstanceLoss(const Field& field) {
    field.requireObject({"lost_after_s"});
    return {field.has("lost_after_s") ? field.at("lost_after_s").number(0, kMaxDelay_s) : 0};
}

std::string parseFunction(const Field& field) {
    const std::string function = field.required("call").text();
    if (!isRefusable(function))
        field.at("call").fail("a function that the runtime offers to an instance expected");
    return function;
}

Refusal parseRefusal(const Field& field) {
    field.requireObject({"call", "result", "nth", "times", "for_s"});
    Refusal refusal;
    refusal.function = parseFunction(field);
    const std::string result = field.required("result").text();
    const std::optional<XrResult> named = resultNamed(result);
    if (!named || (XR_SUCCEEDED(*named) && *named != XR_TIMEOUT_EXPIRED))
        field.at("result").fail("the name of an error, XR_ERROR_..., expected");
    refusal.result = *named;
    if (field.has("nth")) refusal.nth = field.at("nth").integer(1, 1'000'000'000);
    if (field.has("times")) refusal.times = field.at("times").integer(1, 1'000'000'000);
    if (!field.has("for_s")) return refusal;
    if (field.has("nth") || field.has("times"))
        field.at("for_s").fail("either for_s or nth and times expected");
    refusal.for_s = field.at("for_s").number(0, kMaxNumber);
    return refusal;
}

Stall parseStall(const Field& field) {
    constexpr double kMaxStall_s = 10;
    field.requireObject({"call", "for_s", "nth"});
    Stall stall;
    stall.function = parseFunction(field);
    stall.for_s = field.required("for_s").number(0, kMaxStall_s);
    if (field.has("nth")) stall.nth = field.at("nth").integer(1, 1'000'000'000);
    return stall;
}

FrameOverrides parseFrameOverrides(const Field& field) {
    field.requireObject({"late", "not_rendered", "discarded", "dropped", "count"});
    FrameOverrides frame_overrides;
    FrameOverride& each = frame_overrides.frame_override;
    if (field.has("late"))
        each.late_refreshes = static_cast<std::uint32_t>(field.at("late").integer(0, 10'000));
    if (field.has("not_rendered")) each.should_render = !field.at("not_rendered").boolean();
    if (field.has("discarded")) each.discarded = field.at("discarded").boolean();
    if (field.has("dropped")) each.dropped = field.at("dropped").boolean();
    if (field.has("count")) frame_overrides.count = field.at("count").integer(1, 1'000'000'000);
    return frame_overrides;
}

CaptureRequest parseCapture(const Field& field) {
    const std::string name = field.text();
    if (captureName("capture:" + name).empty()) field.fail("a plain file name expected");
    return {name};
}

constexpr const char* kActions[] = {"recenter",      "visibility_mask", "interaction_profile",
                                    "refresh_hz",    "user_presence",   "session_loss",
                                    "instance_loss", "refuse",          "frames",
                                    "session",       "capture",         "stall",
                                    "head_tracked"};

void parseAction(const Field& field, const std::string& kind, Event& event) {
    if (kind == "recenter") event.action = parseRecentring(field);
    if (kind == "visibility_mask") event.action = parseMaskChange(field);
    if (kind == "interaction_profile") event.action = parseProfileChange(field);
    if (kind == "refresh_hz") event.action = RefreshRateChange{field.number(1, 1000)};
    if (kind == "user_presence") event.action = PresenceChange{field.boolean()};
    if (kind == "head_tracked") event.action = HeadTracking{field.boolean()};
    if (kind == "session_loss") event.action = parseSessionLoss(field);
    if (kind == "instance_loss") event.action = parseInstanceLoss(field);
    if (kind == "refuse") event.action = parseRefusal(field);
    if (kind == "stall") event.action = parseStall(field);
    if (kind == "frames") event.action = parseFrameOverrides(field);
    if (kind == "session") event.action = TargetChange{parseTarget(field)};
    if (kind == "capture") event.action = parseCapture(field);
}

Event parseEvent(const Field& field, const ReadContext& context) {
    field.requireObject();
    Event event;
    const std::string kind = field.onlyKey({"t_s", "frame"}, kActions, "event");
    if (field.has("t_s") && field.has("frame")) field.fail("either t_s or frame expected");
    if (field.has("frame"))
        event.frame = field.at("frame").integer(1, 1'000'000'000);
    else if (field.has("t_s") || !context.is_message)
        event.t_s = field.required("t_s").number(0, kMaxNumber);
    event.t_s += context.now_s;
    parseAction(field.at(kind), kind, event);
    return event;
}

}  // namespace

SessionTarget parseTarget(const Field& field) {
    constexpr SessionTarget kTargets[] = {SessionTarget::focused, SessionTarget::visible,
                                          SessionTarget::synchronized, SessionTarget::stopped,
                                          SessionTarget::exiting};
    return kTargets[field.oneOf({"focused", "visible", "synchronized", "stopped", "exiting"})];
}

namespace {

// Convex and counter-clockwise: no corner is to the right of an edge, and the area is positive.
bool isConvex(const LensOutline& outline) {
    double twice_area = 0;
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const auto &a = outline[i], &b = outline[(i + 1) % outline.size()];
        twice_area += a[0] * b[1] - a[1] * b[0];
        for (const auto& c : outline)
            if ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) < -1e-12) return false;
    }
    return twice_area > 0;
}

}  // namespace

std::array<LensOutline, 2> parseLens(const Field& field) {
    constexpr double kMaxTangent = 100;
    constexpr std::size_t kMaxCorners = 256, kCircleCorners = 32;
    field.requireObject({"outline", "radius", "centre"});
    if (field.has("outline") == field.has("radius")) field.fail("either outline or radius expected");
    LensOutline left;
    if (field.has("outline")) {
        const Field outline = field.at("outline");
        if (outline.arraySize(kMaxCorners) < 3) outline.fail("at least three corners expected");
        for (std::size_t i = 0; i < outline.arraySize(); ++i)
            left.push_back(outline.at(i).numbers<2>(-kMaxTangent, kMaxTangent));
        if (!isConvex(left)) outline.fail("convex and counter-clockwise expected");
    } else {
        const double radius = field.at("radius").number(0.01, kMaxTangent);
        std::array<double, 2> centre{0, 0};
        if (field.has("centre")) centre = field.at("centre").numbers<2>(-kMaxTangent, kMaxTangent);
        for (std::size_t i = 0; i < kCircleCorners; ++i) {
            const double turn = 2 * std::numbers::pi * static_cast<double>(i) / kCircleCorners;
            left.push_back({centre[0] + radius * std::cos(turn), centre[1] + radius * std::sin(turn)});
        }
    }
    LensOutline right(left.rbegin(), left.rend());
    for (auto& corner : right)
        corner[0] = -corner[0];
    return {left, right};
}

std::vector<Event> parseEvents(const Field& field, const ReadContext& context) {
    std::vector<Event> events;
    for (std::size_t i = 0; i < field.arraySize(kMaxEvents); ++i)
        events.push_back(parseEvent(field.at(i), context));
    return events;
}

std::string captureName(const std::string& label) {
    if (!label.starts_with(kCapturePrefix)) return {};
    const std::string name = label.substr(sizeof kCapturePrefix - 1);
    const bool plain = std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
               c == '-' || c == '.';
    });
    return plain && name.size() <= kMaxCaptureName && !name.starts_with('.') ? name : std::string();
}

}  // namespace xrmock
