#include "assertions.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "call.h"
#include "composition.h"
#include "names.h"
#include "objects.h"
#include "spaces.h"
#include "submitted_frame.h"

namespace xrmock {

namespace {

constexpr std::uint64_t kMostFrames = 1'000'000'000;

template <class... Parts>
std::string sentence(const Parts&... parts) {
    std::ostringstream text;
    (text << ... << parts);
    return text.str();
}

std::uint64_t parseCount(const Field& field) {
    return field.integer(0, kMostFrames);
}

ViewsWithin parseViews(const Field& field) {
    field.objectOf({"position_m", "angle_rad"});
    return {field.required("position_m").number(0, 1000), field.required("angle_rad").number(0, 4)};
}

DepthRange parseDepth(const Field& field) {
    field.objectOf({"near_m", "far_m"});
    return {field.required("near_m").numbers<2>(0, kMaxNumber),
            field.required("far_m").numbers<2>(0, kMaxNumber)};
}

PulseWithin parsePulse(const Field& field) {
    field.objectOf({"hand", "from_s", "to_s", "at_least", "amplitude_at_least"});
    const double from_s = field.required("from_s").number(0, kMaxNumber);
    PulseWithin pulse{{}, from_s, field.required("to_s").number(from_s, kMaxNumber), 1, 0};
    if (field.has("hand")) pulse.user = static_cast<User>(field.at("hand").oneOf({"left", "right"}));
    if (field.has("at_least")) pulse.at_least = field.at("at_least").integer(1, kMaxPulses);
    if (field.has("amplitude_at_least")) {
        pulse.amplitude_at_least = field.at("amplitude_at_least").number(0, 1);
    }
    return pulse;
}

PixelIs parsePixel(const Field& field) {
    field.objectOf({"frame", "eye", "at", "rgb", "tolerance"});
    const auto at = field.required("at").numbers<2>(0, 1);
    return {field.required("frame").integer(1, kMostFrames),
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

void parseDemand(const Field& field, const std::string& kind, Assertion& assertion) {
    auto& demand = assertion.demand;
    if (kind == "frames_at_least") demand = FramesAtLeast{parseCount(field)};
    if (kind == "discarded_at_most") demand = CountAtMost{Counted::discarded, parseCount(field)};
    if (kind == "missed_at_most") demand = CountAtMost{Counted::missed, parseCount(field)};
    if (kind == "refusals_at_most") demand = CountAtMost{Counted::refusals, parseCount(field)};
    if (kind == "every_frame_has") {
        demand = EveryFrameHas{static_cast<Part>(field.oneOf({"projection", "quad", "cylinder", "depth"}))};
    }
    if (kind == "views_within") demand = parseViews(field);
    if (kind == "format") demand = FormatIs{static_cast<std::int64_t>(field.integer(0, 1'000'000'000))};
    if (kind == "depth_range") demand = parseDepth(field);
    if (kind == "haptic_pulse") demand = parsePulse(field);
    if (kind == "pixel") demand = parsePixel(field);
    if (kind == "states") demand = parseStates(field);
}

constexpr const char* kKinds[] = {"frames_at_least", "discarded_at_most",
                                  "missed_at_most",  "refusals_at_most",
                                  "every_frame_has", "views_within",
                                  "format",          "depth_range",
                                  "haptic_pulse",    "pixel",
                                  "states"};

template <class Demand>
constexpr bool kLooksAtEveryFrame =
    std::is_same_v<Demand, EveryFrameHas> || std::is_same_v<Demand, ViewsWithin> ||
    std::is_same_v<Demand, FormatIs> || std::is_same_v<Demand, DepthRange>;

Assertion parseAssertion(const Field& field, std::size_t index) {
    field.object();
    Assertion assertion;
    std::string kind;
    for (const auto& [key, unused] : field.value.items()) {
        if (key == "name" || key == "frames") continue;
        if (std::find(std::begin(kKinds), std::end(kKinds), key) == std::end(kKinds)) {
            field.at(key).fail("unknown field");
        }
        if (!kind.empty()) field.fail("one demand expected, not " + kind + " and " + key);
        kind = key;
    }
    if (kind.empty()) field.fail("a demand expected");
    parseDemand(field.at(kind), kind, assertion);
    assertion.name = field.has("name") ? field.at("name").text() : sentence(kind, " (", index + 1, ")");
    if (field.has("frames")) {
        const Field frames = field.at("frames");
        const bool counts =
            std::visit([](const auto& demand) { return kLooksAtEveryFrame<std::decay_t<decltype(demand)>>; },
                       assertion.demand);
        if (!counts) {
            frames.fail("only for demands that look at every frame");
        }
        if (frames.arraySize() != 2) frames.fail("the first and the last frame expected");
        assertion.first_frame = frames.at(0).integer(1, kMostFrames);
        assertion.last_frame = frames.at(1).integer(assertion.first_frame, kMostFrames);
    }
    return assertion;
}

// Input of all checks of one frame. Each check returns the reason of a failure, or "".
struct Look {
    Session& session;
    const SubmittedFrame& frame;
};

template <class Check>
std::string eachView(const SubmittedFrame& frame, Check check) {
    for (const SubmittedLayer& layer : frame.layers) {
        if (layer.type != LayerType::projection) continue;
        for (std::size_t eye = 0; eye < 2; ++eye) {
            const std::string failure = check(layer, eye);
            if (!failure.empty()) return std::string(eye == 0 ? "left" : "right") + " eye: " + failure;
        }
    }
    return {};
}

std::string failureOf(const EveryFrameHas& demand, const Look& look) {
    const bool found =
        std::any_of(look.frame.layers.begin(), look.frame.layers.end(), [&](const SubmittedLayer& layer) {
            if (demand.part == Part::depth) {
                return layer.type == LayerType::projection && layer.views[0].depth && layer.views[1].depth;
            }
            return static_cast<std::size_t>(layer.type) == static_cast<std::size_t>(demand.part);
        });
    return found ? "" : "there is no such layer";
}

std::string failureOf(const ViewsWithin& demand, const Look& look) {
    const auto stage_from_eyes = stageFromEyes(look.session.instance, look.frame.display_time);
    return eachView(look.frame, [&](const SubmittedLayer& layer, std::size_t eye) -> std::string {
        if (!layer.stage_from_space) return "the layer's space cannot be located";
        const Pose submitted = *layer.stage_from_space * layer.views[eye].space_from_eye;
        const Pose& located = stage_from_eyes[eye];
        const Vec3 turn = rotationBetween(located, submitted);
        const double distance_m = std::hypot(submitted.position[0] - located.position[0],
                                             submitted.position[1] - located.position[1],
                                             submitted.position[2] - located.position[2]);
        const double angle_rad = std::hypot(turn[0], turn[1], turn[2]);
        if (distance_m <= demand.position_m && angle_rad <= demand.angle_rad) return {};
        return sentence(distance_m, " m and ", angle_rad, " rad from the located view");
    });
}

std::string failureOf(const FormatIs& demand, const Look& look) {
    return eachView(look.frame, [&](const SubmittedLayer& layer, std::size_t eye) -> std::string {
        const auto format = static_cast<std::int64_t>(layer.views[eye].image.swapchain->images.format);
        return format == demand.format ? "" : sentence("format ", format);
    });
}

std::string failureOf(const DepthRange& demand, const Look& look) {
    return eachView(look.frame, [&](const SubmittedLayer& layer, std::size_t eye) -> std::string {
        const auto& depth = layer.views[eye].depth;
        if (!depth) return "there is no depth";
        const double near_m = std::min(depth->near_z_m, depth->far_z_m);
        const double far_m = std::max(depth->near_z_m, depth->far_z_m);
        const auto within = [](double value, const std::array<double, 2>& range) {
            value = std::min(value, kMaxNumber);  // planes may be at infinity
            return value >= range[0] && value <= range[1];
        };
        if (within(near_m, demand.near_m) && within(far_m, demand.far_m)) return {};
        return sentence("depth from ", near_m, " m to ", far_m, " m");
    });
}

std::string failureOf(const PixelIs& demand, const Look& look) {
    const Picture picture = composeEye(look.session, look.frame, demand.eye);
    const auto at = [](double part, std::uint32_t size) {
        return std::min(static_cast<std::size_t>(part * size), static_cast<std::size_t>(size) - 1);
    };
    const std::size_t offset =
        (at(demand.y, picture.height) * picture.width + at(demand.x, picture.width)) * 4;
    for (std::size_t i = 0; i < 3; ++i) {
        if (std::abs(picture.rgba[offset + i] - demand.rgb[i]) <= demand.tolerance) continue;
        return sentence("the pixel is ", int{picture.rgba[offset]}, ", ", int{picture.rgba[offset + 1]}, ", ",
                        int{picture.rgba[offset + 2]});
    }
    return {};
}

void assertOn(Assertion& assertion, const Look& look) {
    std::visit(
        [&](const auto& demand) {
            using Demand = std::decay_t<decltype(demand)>;
            constexpr bool kIsPixel = std::is_same_v<Demand, PixelIs>;
            if constexpr (kIsPixel || kLooksAtEveryFrame<Demand>) {
                if constexpr (kIsPixel) {
                    if (look.frame.number != demand.frame) return;
                }
                ++assertion.checked;
                const std::string failure = failureOf(demand, look);
                if (!failure.empty()) {
                    assertion.failure = sentence("frame ", look.frame.number, ": ", failure);
                }
            }
        },
        assertion.demand);
}

std::string judge(const FramesAtLeast& demand, const Assertion&, const Instance& instance) {
    if (instance.statistics.submitted >= demand.count) return {};
    return sentence(instance.statistics.submitted, " frames instead of at least ", demand.count);
}

std::string judge(const CountAtMost& demand, const Assertion&, const Instance& instance) {
    const Statistics& counts = instance.statistics;
    const std::uint64_t count = demand.counted == Counted::discarded ? counts.discarded
                                : demand.counted == Counted::missed  ? counts.missed
                                                                     : counts.refusals;
    if (count <= demand.most) return {};
    std::string reason = sentence(count, " instead of at most ", demand.most);
    if (demand.counted == Counted::refusals) reason += "; the first: " + instance.first_refusal;
    return reason;
}

std::string judge(const PulseWithin& demand, const Assertion& assertion, const Instance&) {
    if (assertion.checked >= demand.at_least) return {};
    return sentence(assertion.checked, " pulses instead of at least ", demand.at_least);
}

std::string judge(const StatesReached& demand, const Assertion& assertion, const Instance&) {
    if (assertion.checked >= demand.states.size()) return {};
    return sessionStateName(demand.states[assertion.checked]) + " was not reached";
}

template <class Demand>
std::string judge(const Demand&, const Assertion& assertion, const Instance&) {
    return assertion.checked > 0 ? "" : "no frame to look at was submitted";
}

// Counts the pulses that started since the last frame.
void countPulses(Assertion& assertion, const Session& session, std::uint64_t seen) {
    const auto* demand = std::get_if<PulseWithin>(&assertion.demand);
    if (demand == nullptr) return;
    for (const HapticPulse& pulse : session.haptics.pulses) {
        const double start_s = session.instance.clock.scenarioSeconds(pulse.start_ns);
        const bool counts = pulse.number > seen && (!demand->user || pulse.user == *demand->user) &&
                            start_s >= demand->from_s && start_s <= demand->to_s &&
                            pulse.amplitude >= demand->amplitude_at_least;
        if (counts) ++assertion.checked;
    }
}

}  // namespace

std::vector<Assertion> parseAssertions(const Field& field) {
    std::vector<Assertion> assertions;
    for (std::size_t i = 0; i < field.arraySize(10'000); ++i)
        assertions.push_back(parseAssertion(field.at(i), i));
    return assertions;
}

void assertFrame(Call& call, Session& session, const SubmittedFrame& frame) {
    auto& assertions = session.instance.scenario.assertions;
    if (assertions.empty()) return;
    const bool rendered = session.frames.begun_fate.should_render;  // as reported by xrWaitFrame
    for (Assertion& assertion : assertions) {
        countPulses(assertion, session, session.pulses_seen);
        if (!rendered || !assertion.failure.empty() || frame.number < assertion.first_frame ||
            frame.number > assertion.last_frame) {
            continue;
        }
        try {
            assertOn(assertion, {session, frame});
        } catch (const Refused& refused) {
            warn(call, "assertion " + assertion.name + ": " + refused.reason);
            assertion.failure = refused.reason;
        }
    }
    session.pulses_seen = session.haptics.started;
}

void assertState(Instance& instance, XrSessionState state) {
    for (Assertion& assertion : instance.scenario.assertions) {
        const auto* demand = std::get_if<StatesReached>(&assertion.demand);
        if (demand == nullptr || assertion.checked >= demand->states.size()) continue;
        if (demand->states[assertion.checked] == state) ++assertion.checked;
    }
}

std::string verdict(const Assertion& assertion, const Instance& instance) {
    if (!assertion.failure.empty()) return assertion.failure;
    return std::visit([&](const auto& demand) { return judge(demand, assertion, instance); },
                      assertion.demand);
}

}  // namespace xrmock
