#include "haptics/loop/trace.h"

#include <cmath>

namespace stylet::haptics {

namespace {

// Normalised linear interpolation along the shorter arc.
Quat nlerp(const Quat& a, const Quat& b, double share) noexcept {
    const double sign = glm::dot(a, b) < 0.0 ? -1.0 : 1.0;
    const Quat q = a * (1.0 - share) + b * (sign * share);
    const double norm = std::sqrt(glm::dot(q, q));
    return norm > 0.0 ? Quat(q.w / norm, q.x / norm, q.y / norm, q.z / norm) : a;
}

}  // namespace

TraceSample sampleAt(const Trace& trace, std::int64_t t_ns, std::size_t& hint) noexcept {
    const std::vector<TraceSample>& samples = trace.samples;
    if (samples.empty()) return {t_ns, {}, 0};
    if (hint >= samples.size() || samples[hint].t_ns > t_ns) hint = 0;
    while (hint + 1 < samples.size() && samples[hint + 1].t_ns <= t_ns)
        ++hint;

    TraceSample out = samples[hint];
    if (t_ns > out.t_ns && hint + 1 < samples.size()) {
        const TraceSample& next = samples[hint + 1];
        const double share = double(t_ns - out.t_ns) / double(next.t_ns - out.t_ns);
        const Pose &a = out.device_from_stylus, &b = next.device_from_stylus;
        out.device_from_stylus = {nlerp(a.rotation, b.rotation, share),
                                  a.position_m + share * (b.position_m - a.position_m)};
    }
    out.t_ns = t_ns;
    return out;
}

}  // namespace stylet::haptics
