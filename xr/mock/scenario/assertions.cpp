#include "scenario/assertions.h"

#include <algorithm>

#include "scenario/names.h"

namespace xrmock {

namespace {

constexpr std::uint64_t kMaxFrames = 1'000'000'000;

std::uint64_t parseCount(const Field& field) {
    return field.integer(0, kMaxFrames);
}

ViewsWithin parseViews(const Field& field) {
    field.requireObject({"position_m", "angle_rad"});
    return {field.required("position_m").number(0, 1000), field.required("angle_rad").number(0, 4)};
}

DepthRange parseDepth(const Field& field) {
    field.requireObject({"near_m", "far_m"});
    return {field.required("near_m").numbers<2>(0, kMaxNumber),
            field.required("far_m").numbers<2>(0, kMaxNumber)};
}

PulseWithin parsePulse(const Field& field) {
    field.requireObject({"hand", "from_s", "to_s", "at_least", "amplitude_at_least"});
    const double from_s = field.required("from_s").number(0, kMaxNumber);
    PulseWithin pulse{{}, from_s, field.required("to_s").number(from_s, kMaxNumber), 1, 0};
    if (field.has("hand")) pulse.user = static_cast<User>(field.at("hand").oneOf({"left", "right"}));
    if (field.has("at_least")) pulse.at_least = field.at("at_least").integer(1, kMaxPulses);
    if (field.has("amplitude_at_least"))
        pulse.amplitude_at_least = field.at("amplitude_at_least").number(0, 1);
    return pulse;
}

PixelIs parsePixel(const Field& field) {
    field.requireObject({"frame", "eye", "at", "rgb", "tolerance"});
    const auto at = field.required("at").numbers<2>(0, 1);
    return {field.required("frame").integer(1, kMaxFrames),
            field.required("eye").oneOf({"left", "right"}),
            at[0],
            at[1],
            field.required("rgb").numbers<3>(0, 255),
            field.has("tolerance") ? field.at("tolerance").number(0, 255) : 0};
}

StatesReached parseStates(const Field& field) {
    StatesReached reached;
    if (field.arraySize() == 0) field.fail("at least one state expected");
    for (std::size_t i = 0; i < field.arraySize(1000); ++i) {
        const auto state = sessionStateNamed(field.at(i).text());
        if (!state) field.at(i).fail("the name of a session state expected");
        reached.states.push_back(*state);
    }
    return reached;
}

void parseRequirement(const Field& field, const std::string& kind, Assertion& assertion) {
    auto& requirement = assertion.requirement;
    if (kind == "frames_at_least") requirement = FramesAtLeast{parseCount(field)};
    if (kind == "discarded_at_most") requirement = CountAtMost{Counter::discarded, parseCount(field)};
    if (kind == "missed_at_most") requirement = CountAtMost{Counter::missed, parseCount(field)};
    if (kind == "refusals_at_most") requirement = CountAtMost{Counter::refusals, parseCount(field)};
    if (kind == "every_frame_has") {
        requirement =
            EveryFrameHas{static_cast<Part>(field.oneOf({"projection", "quad", "cylinder", "depth"}))};
    }
    if (kind == "views_within") requirement = parseViews(field);
    if (kind == "format") requirement = FormatIs{static_cast<std::int64_t>(field.integer(0, 1'000'000'000))};
    if (kind == "depth_range") requirement = parseDepth(field);
    if (kind == "haptic_pulse") requirement = parsePulse(field);
    if (kind == "pixel") requirement = parsePixel(field);
    if (kind == "states") requirement = parseStates(field);
}

constexpr const char* kKinds[] = {"frames_at_least", "discarded_at_most",
                                  "missed_at_most",  "refusals_at_most",
                                  "every_frame_has", "views_within",
                                  "format",          "depth_range",
                                  "haptic_pulse",    "pixel",
                                  "states"};

Assertion parseAssertion(const Field& field, std::size_t index) {
    field.requireObject();
    Assertion assertion;
    const std::string kind = field.onlyKey({"name", "frames"}, kKinds, "assertion");
    parseRequirement(field.at(kind), kind, assertion);
    assertion.name =
        field.has("name") ? field.at("name").text() : kind + " (" + std::to_string(index + 1) + ")";
    if (field.has("frames")) {
        const Field frames = field.at("frames");
        const bool counts = std::visit(
            [](const auto& requirement) { return kChecksEveryFrame<std::decay_t<decltype(requirement)>>; },
            assertion.requirement);
        if (!counts) frames.fail("only for demands that look at every frame");
        if (frames.arraySize() != 2) frames.fail("the first and the last frame expected");
        assertion.first_frame = frames.at(0).integer(1, kMaxFrames);
        assertion.last_frame = frames.at(1).integer(assertion.first_frame, kMaxFrames);
    }
    return assertion;
}

}  // namespace

std::vector<Assertion> parseAssertions(const Field& field) {
    std::vector<Assertion> assertions;
    for (std::size_t i = 0; i < field.arraySize(10'000); ++i)
        assertions.push_back(parseAssertion(field.at(i), i));
    return assertions;
}

}  // namespace xrmock
