#include "app/trainer/loop/picture_watch.h"

#include <fmt/core.h>

namespace stylet::trainer {

std::string PictureWatch::update(std::int64_t now_ns, std::int64_t drawn_ns, bool attempt_paused) {
    const bool was = stalled_;
    stalled_ = now_ns - drawn_ns > kPictureStalled_ns;
    if (stalled_) {
        if (!was) began_ns_ = drawn_ns;
        length_ns_ = now_ns - began_ns_;
    }
    if (stalled_ == was) return "";
    const double length_s = double(length_ns_) * 1e-9;
    if (stalled_)
        return fmt::format("the picture has stopped for {:.0f} s; {}", length_s,
                           attempt_paused ? "the attempt stays paused" : "the attempt continues");
    ended_ns_ = now_ns;
    return fmt::format("the picture moves again; it had stopped for {:.0f} s", length_s);
}

double PictureWatch::shown_s(std::int64_t now_ns, bool force_off) {
    if (!stalled_ && !force_off && now_ns - ended_ns_ > kShown_ns) length_ns_ = 0;
    return double(length_ns_) * 1e-9;
}

}  // namespace stylet::trainer
