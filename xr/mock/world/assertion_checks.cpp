#include "world/assertion_checks.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "scenario/names.h"
#include "world/call.h"
#include "world/composition.h"
#include "world/objects.h"
#include "world/spaces.h"
#include "world/submitted_frame.h"

namespace xrmock {

namespace {

template <class... Parts>
std::string sentence(const Parts&... parts) {
    std::ostringstream text;
    (text << ... << parts);
    return text.str();
}

// Input of all checks of one frame. Each check returns the reason of a failure, or "".
struct FrameContext {
    Session& session;
    const SubmittedFrame& frame;
};

template <class Check>
std::string checkEachView(const SubmittedFrame& frame, Check check) {
    for (const SubmittedLayer& layer : frame.layers) {
        if (layer.type != LayerType::projection) continue;
        for (std::size_t eye = 0; eye < 2; ++eye) {
            const std::string failure = check(layer, eye);
            if (!failure.empty()) return std::string(eye == 0 ? "left" : "right") + " eye: " + failure;
        }
    }
    return {};
}

std::string findFailure(const EveryFrameHas& requirement, const FrameContext& context) {
    const bool found = std::any_of(
        context.frame.layers.begin(), context.frame.layers.end(), [&](const SubmittedLayer& layer) {
            if (requirement.part == Part::depth)
                return layer.type == LayerType::projection && layer.views[0].depth && layer.views[1].depth;
            return static_cast<std::size_t>(layer.type) == static_cast<std::size_t>(requirement.part);
        });
    return found ? "" : "there is no such layer";
}

std::string findFailure(const ViewsWithin& requirement, const FrameContext& context) {
    const auto stage_from_eyes = stageFromEyes(context.session.instance, context.frame.display_time);
    return checkEachView(context.frame, [&](const SubmittedLayer& layer, std::size_t eye) -> std::string {
        if (!layer.stage_from_space) return "the layer's space cannot be located";
        const Pose submitted = *layer.stage_from_space * layer.views[eye].space_from_eye;
        const Pose& located = stage_from_eyes[eye];
        const Vec3 turn = rotationBetween(located, submitted);
        const double distance_m = std::hypot(submitted.position[0] - located.position[0],
                                             submitted.position[1] - located.position[1],
                                             submitted.position[2] - located.position[2]);
        const double angle_rad = std::hypot(turn[0], turn[1], turn[2]);
        if (distance_m <= requirement.position_m && angle_rad <= requirement.angle_rad) return {};
        return sentence(distance_m, " m and ", angle_rad, " rad from the located view");
    });
}

std::string findFailure(const FormatIs& requirement, const FrameContext& context) {
    return checkEachView(context.frame, [&](const SubmittedLayer& layer, std::size_t eye) -> std::string {
        const auto format = static_cast<std::int64_t>(layer.views[eye].image.swapchain->images.format);
        return format == requirement.format ? "" : sentence("format ", format);
    });
}

std::string findFailure(const DepthRange& requirement, const FrameContext& context) {
    return checkEachView(context.frame, [&](const SubmittedLayer& layer, std::size_t eye) -> std::string {
        const auto& depth = layer.views[eye].depth;
        if (!depth) return "there is no depth";
        const double near_m = std::min(depth->near_z_m, depth->far_z_m);
        const double far_m = std::max(depth->near_z_m, depth->far_z_m);
        const auto within = [](double value, const std::array<double, 2>& range) {
            value = std::min(value, kMaxNumber);  // planes may be at infinity
            return value >= range[0] && value <= range[1];
        };
        if (within(near_m, requirement.near_m) && within(far_m, requirement.far_m)) return {};
        return sentence("depth from ", near_m, " m to ", far_m, " m");
    });
}

std::string findFailure(const PixelIs& requirement, const FrameContext& context) {
    const Picture picture = composeEye(context.session, context.frame, requirement.eye);
    const auto at = [](double part, std::uint32_t size) {
        return std::min(static_cast<std::size_t>(part * size), static_cast<std::size_t>(size) - 1);
    };
    const std::size_t offset =
        (at(requirement.y, picture.height) * picture.width + at(requirement.x, picture.width)) * 4;
    for (std::size_t i = 0; i < 3; ++i) {
        if (std::abs(picture.rgba[offset + i] - requirement.rgb[i]) <= requirement.tolerance) continue;
        return sentence("the pixel is ", int{picture.rgba[offset]}, ", ", int{picture.rgba[offset + 1]}, ", ",
                        int{picture.rgba[offset + 2]});
    }
    return {};
}

void checkAssertion(Assertion& assertion, const FrameContext& context) {
    std::visit(
        [&](const auto& requirement) {
            using Requirement = std::decay_t<decltype(requirement)>;
            constexpr bool kIsPixel = std::is_same_v<Requirement, PixelIs>;
            if constexpr (kIsPixel || kChecksEveryFrame<Requirement>) {
                if constexpr (kIsPixel) {
                    if (context.frame.number != requirement.frame) return;
                }
                ++assertion.checked;
                const std::string failure = findFailure(requirement, context);
                if (!failure.empty())
                    assertion.failure = sentence("frame ", context.frame.number, ": ", failure);
            }
        },
        assertion.requirement);
}

std::string evaluate(const FramesAtLeast& requirement, const Assertion&, const Instance& instance) {
    if (instance.statistics.submitted >= requirement.count) return {};
    return sentence(instance.statistics.submitted, " frames instead of at least ", requirement.count);
}

std::string evaluate(const CountAtMost& requirement, const Assertion&, const Instance& instance) {
    const Statistics& counts = instance.statistics;
    const std::uint64_t count = requirement.counter == Counter::discarded ? counts.discarded
                                : requirement.counter == Counter::missed  ? counts.missed
                                                                          : counts.refusals;
    if (count <= requirement.max_count) return {};
    std::string reason = sentence(count, " instead of at most ", requirement.max_count);
    if (requirement.counter == Counter::refusals) reason += "; the first: " + instance.first_refusal;
    return reason;
}

std::string evaluate(const PulseWithin& requirement, const Assertion& assertion, const Instance&) {
    if (assertion.checked >= requirement.at_least) return {};
    return sentence(assertion.checked, " pulses instead of at least ", requirement.at_least);
}

std::string evaluate(const StatesReached& requirement, const Assertion& assertion, const Instance&) {
    if (assertion.checked >= requirement.states.size()) return {};
    return sessionStateName(requirement.states[assertion.checked]) + " was not reached";
}

template <class Requirement>
std::string evaluate(const Requirement&, const Assertion& assertion, const Instance&) {
    return assertion.checked > 0 ? "" : "no frame to look at was submitted";
}

// Counts the pulses that started since the last frame.
void countPulses(Assertion& assertion, const Session& session, std::uint64_t seen) {
    const auto* requirement = std::get_if<PulseWithin>(&assertion.requirement);
    if (requirement == nullptr) return;
    for (const HapticPulse& pulse : session.haptics.pulses) {
        const double start_s = session.instance.clock.scenarioSeconds(pulse.start_ns);
        const bool counts = pulse.number > seen && (!requirement->user || pulse.user == *requirement->user) &&
                            start_s >= requirement->from_s && start_s <= requirement->to_s &&
                            pulse.amplitude >= requirement->amplitude_at_least;
        if (counts) ++assertion.checked;
    }
}

}  // namespace

void checkFrameAssertions(Call& call, Session& session, const SubmittedFrame& frame) {
    auto& assertions = session.instance.scenario.assertions;
    if (assertions.empty()) return;
    const bool rendered = session.frames.begun_override.should_render;  // as reported by xrWaitFrame
    for (Assertion& assertion : assertions) {
        countPulses(assertion, session, session.pulses_seen);
        if (!rendered || !assertion.failure.empty() || frame.number < assertion.first_frame ||
            frame.number > assertion.last_frame) {
            continue;
        }
        try {
            checkAssertion(assertion, {session, frame});
        } catch (const Refused& refused) {
            warn(call, "assertion " + assertion.name + ": " + refused.reason);
            assertion.failure = refused.reason;
        }
    }
    session.pulses_seen = session.haptics.started;
}

void checkStateAssertions(Instance& instance, XrSessionState state) {
    for (Assertion& assertion : instance.scenario.assertions) {
        const auto* requirement = std::get_if<StatesReached>(&assertion.requirement);
        if (requirement == nullptr || assertion.checked >= requirement->states.size()) continue;
        if (requirement->states[assertion.checked] == state) ++assertion.checked;
    }
}

std::string evaluateAssertion(const Assertion& assertion, const Instance& instance) {
    if (!assertion.failure.empty()) return assertion.failure;
    return std::visit([&](const auto& requirement) { return evaluate(requirement, assertion, instance); },
                      assertion.requirement);
}

}  // namespace xrmock
