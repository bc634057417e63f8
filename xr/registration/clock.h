// Two pose streams of the same motion with different delays: estimates the offset between them and pairs
// their samples.
#pragma once

#include <span>
#include <vector>

#include "xr/registration/fit.h"

namespace stylet::xr::registration {

struct Timed {
    double t_s = 0.0;
    Rigid pose;
};
using Stream = std::span<const Timed>;  // times increase

// Interpolates linearly in position and spherically in orientation. Returns nullopt outside the stream and
// in gaps longer than 0.1 s.
std::optional<Rigid> poseAt(Stream, double t_s);

struct Offset {
    double late_s = 0.0;       // `tracked` at time t corresponds to `device` at t - late_s
    double correlation = 0.0;  // Pearson correlation of the speeds at this offset, at most 1
};
// Finds the offset at which the two speed curves correlate best, refined by a parabola between grid steps.
// Searches up to `most_s` in both directions. Refuses streams that overlap for less than 2 s, move too
// little or correlate too weakly.
Answer<Offset> clockOffset(Stream device, Stream tracked, double most_s = 0.25);

// Makes one pair per `step_s`: the tracked pose, the device pose `late_s` earlier, and the tip velocity
// there.
std::vector<Pair> pairUp(Stream device, Stream tracked, double late_s, double step_s);

// Registration from motion: estimates the offset, pairs the streams, and fits. The fit refines the offset
// and the pairing is repeated until the offset settles. `latency_s` of the result is the total offset.
Answer<Fit> fitMotion(Stream device, Stream tracked, FitSettings);

// Mean pose of a stylus or controller held still, and the largest distance of a sample from the mean
// position. Refuses an empty stream and non-finite numbers.
struct Held {
    Rigid pose;
    double spread_m = 0.0;
};
Answer<Held> meanPose(Stream);

}  // namespace stylet::xr::registration
