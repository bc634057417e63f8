// Estimates the time offset between two pose streams of the same motion, which have different delays, and
// pairs their samples.
#pragma once

#include <span>
#include <vector>

#include "xr/registration/fit.h"

namespace stylet::xr::registration {

struct TimedPose {
    double t_s = 0.0;
    Pose pose;
};
using PoseStream = std::span<const TimedPose>;  // times increase

// Interpolates linearly in position and spherically in orientation. Returns nullopt outside the stream and
// in gaps longer than 0.1 s.
std::optional<Pose> poseAt(PoseStream, double t_s);

struct TimeOffset {
    double delay_s = 0.0;      // `tracked` at time t corresponds to `device` at t - delay_s
    double correlation = 0.0;  // Pearson correlation of the speeds at this offset, at most 1
};
// Finds the offset at which the two speed curves correlate best, refined by a parabola between grid steps.
// Searches up to `max_offset_s` in both directions. Refuses streams that overlap for less than 2 s, move too
// little or correlate too weakly.
Result<TimeOffset> estimateClockOffset(PoseStream device, PoseStream tracked, double max_offset_s = 0.25);

// Makes one pair per `step_s`: the tracked pose, the device pose `delay_s` earlier, and the tip velocity
// there.
std::vector<Pair> pairSamples(PoseStream device, PoseStream tracked, double delay_s, double step_s);

// Registration from motion: estimates the offset, pairs the streams, and fits. The fit refines the offset
// and the pairing is repeated until the offset settles. `latency_s` of the result is the total offset.
Result<Fit> fitMotion(PoseStream device, PoseStream tracked, FitSettings);

// Mean pose of a stylus or controller held still, and the largest distance of a sample from the mean
// position. Refuses an empty stream and non-finite numbers.
struct MeanPose {
    Pose pose;
    double spread_m = 0.0;
};
Result<MeanPose> meanPose(PoseStream);

}  // namespace stylet::xr::registration
