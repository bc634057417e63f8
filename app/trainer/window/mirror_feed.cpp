#include "app/trainer/window/mirror_feed.h"

#include <chrono>
#include <utility>

namespace stylet::trainer {
namespace {

std::int64_t now_ns() {
    return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

}  // namespace

void publishScreen(Latest<ScreenUpdate>& channel, const render::ScreenPicture& screen, bool up_to_date,
                   std::uint64_t maker) {
    if (screen.width == 0 || !screen.rgba || !up_to_date) return;
    ScreenUpdate& draft = channel.draft();
    draft.shown_ns = now_ns();
    if (draft.revision != screen.revision || draft.maker != maker) {
        draft.maker = maker, draft.revision = screen.revision;
        draft.image.width = std::uint32_t(screen.width), draft.image.height = std::uint32_t(screen.height);
        draft.image.rgba.assign(screen.rgba,
                                screen.rgba + std::size_t(4) * draft.image.width * draft.image.height);
    }
    channel.publish();
}

void publishState(MirrorChannels& channels, StateUpdate state) {
    const haptics::TickOutput& tick = state.seen.tick;
    const ForceComparisonReading& truth = state.seen.truth;
    const double force_n = toolForce_n(tick);
    const FrameSample sample{
        .time_s = state.tick_s * double(tick.tick),
        .frame_ms = state.time.frame_ms,
        .depth_m = tick.depth_m,
        .force_n = force_n,
        .other_n = truth.known && haptics::isNeedleTool(tick.tool) ? truth.other_n() : force_n};
    channels.state.draft() = std::move(state);
    channels.state.publish();
    channels.samples.push(sample);
}

MirrorFeed::MirrorFeed(MirrorChannels& channels, const render::Gpu& gpu, double tick_s)
    : channels_(&channels), tap_(gpu), tick_s_(tick_s), maker_(++channels.makers) {}

render::VisibleScreens MirrorFeed::screens(const render::VisibleScreens& seen) {
    channels_->requests.read(requests_);
    if (!channels_->open.load()) requests_ = {};
    made_ = seen;
    if (now_ns() >= screens_ns_ + requests_.screens_every_ns) {
        made_.ultrasound |= requests_.ultrasound, made_.xray |= requests_.xray;
        screens_ns_ = now_ns();
    }
    return made_;
}

void MirrorFeed::copyEye(const render::StereoTarget& target, const std::array<render::View, 2>& views,
                         const render::ScreenPlaces& screens, const render::ScreenPicture& monitor) {
    if (requests_.eye < 0 || now_ns() < copied_ns_ + requests_.every_ns) return;
    copied_[copies_ % copied_.size()] = {requests_.eye, views[std::size_t(requests_.eye)], screens};
    publishScreen(channels_->monitor, monitor, true, maker_);
    if (!tap_.submitCopy(target, requests_.eye, requests_.max_pixels, copies_)) return;
    ++copies_;
    copied_ns_ = now_ns();
}

void MirrorFeed::publish(const FrameState& seen, const EquipmentPictures& pictures, const FrameTime& time,
                         Attention attention, std::optional<double> hand_offset_m) {
    if (!channels_->open.load()) return;
    EyeUpdate& eye = channels_->eye.draft();
    if (const auto number = tap_.read(eye.image)) {
        const Copied& copied = copied_[*number % copied_.size()];
        eye.eye = copied.eye, eye.view = copied.view, eye.screens = copied.screens;
        channels_->eye.publish();
    }
    publishScreen(channels_->ultrasound, pictures.ultrasoundScreen(), made_.ultrasound, maker_);
    publishScreen(channels_->xray, pictures.xrayScreen(), made_.xray, maker_);
    publishState(*channels_, {seen, tick_s_, time, hand_offset_m, attention, true});
}

}  // namespace stylet::trainer
