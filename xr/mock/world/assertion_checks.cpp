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
