// Two streams of poses of one motion, each with its own delay: how much later one is, and pairs of the two.
#pragma once

#include <span>
#include <vector>

#include "xr/registration/fit.h"

namespace stylet::xr::registration {

struct Timed {
    double t_s = 0.0;
    Rigid pose;
};
using Stream = std::span<const Timed>;  // times grow

// Linear and spherical between samples. Nothing outside the stream, or in a gap of more than 0.1 s.
std::optional<Rigid> poseAt(Stream, double t_s);

struct Offset {
    double late_s = 0.0;       // `tracked` shows at t what `device` showed at t - late_s
    double correlation = 0.0;  // of the speeds at that offset, at most 1
};
// The offset at which the speeds of both correlate best, between the samples of the search by a parabola.
// Refuses streams that are shorter than two seconds together, that hardly move, or whose speeds do not fit.
Answer<Offset> clockOffset(Stream device, Stream tracked, double most_s = 0.25);

// Pairs every `step_s`, each of `tracked` with `device` as it was `late_s` before, with the tip's velocity.
std::vector<Pair> pairUp(Stream device, Stream tracked, double late_s, double step_s);

// All of it for streams in motion: the offset, then the fit, whose own correction of the offset makes the
// pairs anew. `latency_s` of the fit is the whole offset.
Answer<Fit> fitMotion(Stream device, Stream tracked, FitSettings);

// The mean of poses that are held still, and how far any is from it; refuses none and numbers that are none.
struct Held {
    Rigid pose;
    double spread_m = 0.0;
};
Answer<Held> meanPose(Stream);

}  // namespace stylet::xr::registration
