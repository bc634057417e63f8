#include "app/trainer/session/force_comparison.h"

#include <algorithm>
#include <cmath>

#include "patient/package/segmentation.h"

namespace stylet::trainer {

using haptics::TickOutput;

namespace {

void addError(ForceError& error, double error_n, double depth_m) {
    ++error.ticks;
    error.equal_ticks += error_n == 0.0;
    error.sum_n2 += error_n * error_n;
    if (std::fabs(error_n) <= error.largest_n) return;
    error.largest_n = std::fabs(error_n);
    error.largest_depth_m = depth_m;
}

}  // namespace

double ForceError::rms_n() const {
    return ticks > 0 ? std::sqrt(sum_n2 / double(ticks)) : 0.0;
}

std::optional<OtherSegmentation> loadOtherSegmentation(const patient::Patient& felt,
                                                       const std::filesystem::path& full) {
    OtherSegmentation other;
    other.felt_is_full = full.empty();
    if (full.empty()) {
        if (!patient::isFullySegmented(felt.package())) return std::nullopt;
        other.patient = std::make_unique<patient::Patient>(felt.package(), &patient::isInPartialSegmentation);
        return other;
    }
    auto package = std::make_unique<patient::Package>(patient::loadPackage(full));
    patient::requirePlausible(*package, full, false);
    const patient::Package& mine = felt.package();
    if (package->ct.grid != mine.ct.grid || package->ct.voxels != mine.ct.voxels)
        throw DataError(full, "ct.nii.gz", "is not the CT of the patient on the table, " + mine.name);
    if (!patient::isFullySegmented(*package))
        throw DataError(full, "labels.nii.gz",
                        "label only " + std::to_string(int(100.0 * patient::segmentedShare(*package))) +
                            " % of the body: no full segmentation");
    package->motion = mine.motion;  // use the same breathing motion for both
    other.patient = std::make_unique<patient::Patient>(*package);
    other.package = std::move(package);
    return other;
}

ForceComparison::ForceComparison(const OtherSegmentation& other, const haptics::NeedleSettings& settings)
    : other_(other.patient.get()), settings_(settings) {
    reading_.known = true;
    reading_.felt_is_full = other.felt_is_full;
}

void ForceComparison::step(const TickOutput& now) {
    if (now.cut_incision >= 0) incisions_.list[std::size_t(now.cut_incision)] = now.cut;
    incisions_.count = now.incision_count;
    if (now.tool_resets != begun_) {
        begun_ = now.tool_resets;
        // The tool was picked up outside the felt patient. Reset the other needle too, even if it is inside
        // the other segmentation.
        if (needle_.phase == haptics::Phase::outside)
            needle_.primed = false;
        else
            needle_ = {};
    }
    if (now.tool_awaits_exit || !haptics::isNeedleTool(now.tool)) return;
    const Pose& needle = now.patient_from_needle;
    haptics::stepNeedle(needle_, settings_, {*other_, now.breath},
                        {needle.position_m, needle.direction(Vec3(0.0, 0.0, -1.0))}, events_, incisions_);
}

void ForceComparison::update(const TickOutput& now) {
    step(now);
    if (!haptics::isNeedleTool(now.tool)) {
        reading_.inside = false;  // the needle is outside, or an assistant holds it
        return;
    }
    const bool was_inside = reading_.inside;
    reading_.inside = now.phase != haptics::Phase::outside || needle_.phase != haptics::Phase::outside;
    reading_.full_n = reading_.felt_is_full ? now.force_n : needle_.force_n;
    reading_.partial_n = reading_.felt_is_full ? needle_.force_n : now.force_n;
    if (!reading_.inside) return;
    if (!was_inside) {
        ++reading_.insertions;
        reading_.insertion = {};
    }
    addError(reading_.insertion, reading_.error_n(), now.depth_m);
    addError(reading_.all, reading_.error_n(), now.depth_m);
}

}  // namespace stylet::trainer
