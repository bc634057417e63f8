#include <memory>

#include "app/trainer/frames.h"
#include "app/trainer/pictures.h"

namespace stylet::trainer {

namespace {

PictureTotals totalsOf(const FrameLoop& loop) {
    const FrameTotals from = loop.totals();
    PictureTotals totals;
    totals.frames = from.frames;
    totals.rendered = from.rendered;
    totals.validation_messages = from.validation_messages;
    totals.median_frame_ms = from.median_frame_ms;
    totals.runtime = from.runtime;
    totals.gpu = from.gpu;
    totals.skips = {{"skipped_bricks", from.sum.skipped_bricks},
                    {"terminated_rays", from.sum.terminated_rays},
                    {"depth_bounded_rays", from.sum.depth_bounded_rays},
                    {"still_frames", from.sum.still_frames}};
    return totals;
}

}  // namespace

std::optional<Pictures> openPictures(const patient::Patient& patient, const patient::PlannedPath& path,
                                     const PictureSettings& settings, std::string& why_not) {
    FrameSettings frame_settings;
    frame_settings.assets = settings.assets;
    frame_settings.capture_dir = settings.capture_folder;
    frame_settings.validation = settings.validation;
    frame_settings.virtual_clock = settings.virtual_clock;
    try {
        // Shared because a std::function must be copyable; there is one owner.
        const auto loop = std::make_shared<FrameLoop>(patient, frame_settings, path);
        return Pictures{[loop](const haptics::TickOutput& shown, const std::string& moment) {
                            return loop->frame(shown, moment);
                        },
                        [loop] { return totalsOf(*loop); }, [loop] { return loop->focused(); }};
    } catch (const std::runtime_error& e) {
        why_not = e.what();
        return std::nullopt;
    }
}

}  // namespace stylet::trainer
