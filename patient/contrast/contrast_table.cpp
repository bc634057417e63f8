#include "patient/contrast/contrast_table.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace stylet::patient {

namespace {

constexpr double kMinReach_m = 0.008, kMaxReach_m = 0.08, kReachGrowth = 1.4;

// Attenuation [1/m] of a voxel full of medium, divided by the voxel's volume.
double attenuationPerVolume(const Contrast& contrast) {
    const ContrastSettings& s = contrast.settings();
    return s.iodine_kg_per_m3 * s.attenuation_m2_per_kg / voxelVolume_m3(contrast.patient().grid());
}

}  // namespace

// Collects all volumes that the picture depends on and compares them with those of the last picture.
bool ContrastPainter::hasVisibleChange(const Contrast& contrast) {
    std::vector<double> state;
    for (const DuctTree& tree : contrast.ducts())
        state.insert(state.end(), {tree.base_total_m3, tree.filled_m3});
    for (const Stain& stain : contrast.stains())
        state.insert(state.end(), {stain.spread_m3, stain.volume_m3});
    for (const Plume& plume : contrast.plumes())
        state.insert(state.end(), plume.volume_m3.begin(), plume.volume_m3.end());
    double moved_m3 = state.size() == shown_state_.size() ? 0.0 : 2.0 * settings_.visible_m3;
    for (std::size_t i = 0; i < std::min(state.size(), shown_state_.size()); ++i)
        moved_m3 += std::fabs(state[i] - shown_state_[i]);
    if (state == shown_state_ || moved_m3 < settings_.visible_m3) return false;
    shown_state_ = std::move(state);
    return true;
}

// Enlarges the ball of voxels around each stain until it covers the stain.
void ContrastPainter::growBalls(const Contrast& contrast) {
    const Patient& patient = contrast.patient();
    const Grid& grid = patient.grid();
    const FrontShape& front = contrast.settings().stain_front;
    balls_.resize(contrast.stains().size());
    for (std::size_t s = 0; s < balls_.size(); ++s) {
        const Stain& stain = contrast.stains()[s];
        Ball& ball = balls_[s];
        const double capacity_m3 = porosity(contrast.settings(), stain.kind) * voxelVolume_m3(grid);
        const auto fits = [&] {
            if (ball.order.total() < stain.spread_m3) return false;
            const double front_m = ball.order.frontPosition_m(front, stain.spread_m3);
            return front_m + 0.5 * front.widthAt(front_m) <= ball.reach_m;
        };
        while (ball.reach_m < kMaxReach_m && !fits()) {
            ball.reach_m = std::max(kMinReach_m, kReachGrowth * ball.reach_m);
            const Index3 reach(Vec3(ball.reach_m) / grid.spacing_m + 1.0), at = grid.nearest(stain.centre_m);
            ball.low = glm::max(at - reach - 1, Index3(0));
            ball.high = glm::min(at + reach + 1, grid.dims - 1);
            ball.offsets.clear(), ball.path_m.clear();
            forEachVoxel(ball.low, ball.high, [&](const Index3& i) {
                const double path_m = glm::distance(grid.centre(i), stain.centre_m);
                if (path_m > ball.reach_m || stainTissue(patient, i) != stain.kind) return;
                ball.offsets.push_back(std::uint32_t(grid.offset(i)));
                ball.path_m.push_back(path_m);
            });
            ball.order = FillOrder(ball.path_m, std::vector<double>(ball.path_m.size(), capacity_m3));
        }
    }
}

// Enlarges the box of voxels that are sent for drawing, so that it holds all medium. Returns true if the box
// has changed.
bool ContrastPainter::fitBox(const Contrast& contrast) {
    const Grid& grid = contrast.patient().grid();
    Index3 low = low_, high = high_;
    const auto include = [&](const Index3& from, const Index3& to) {
        const bool empty = low.x > high.x;
        low = empty ? from : glm::min(low, from), high = empty ? to : glm::max(high, to);
    };
    const auto includePiece = [&](const VoxelPiece& piece) {
        include(piece.low, piece.low + piece.box.dims - 1);
    };
    for (const DuctTree& tree : contrast.ducts())
        includePiece(tree.piece);
    for (const Plume& plume : contrast.plumes())
        includePiece(contrast.vessels()[plume.vessel].piece);
    for (const Ball& ball : balls_)
        include(ball.low, ball.high);
    low = glm::max(low, Index3(0)), high = glm::min(high, grid.dims - 1);
    if (low == low_ && high == high_) return false;
    low_ = low, high_ = high;
    box_ = {high - low + 1, grid.spacing_m, grid.centre(low)};
    return true;
}

void ContrastPainter::collectDucts(const Contrast& contrast) {
    const Grid& grid = contrast.patient().grid();
    const FrontShape& shape = contrast.settings().duct_front;
    const double per_m4 = attenuationPerVolume(contrast);
    for (const DuctTree& tree : contrast.ducts()) {
        const double front_m = tree.order.frontPosition_m(shape, tree.filled_m3);
        const double capacity_m3 = ductCapacity_m3(contrast.settings(), tree.piece.box);
        for (std::size_t m = 0; m < tree.piece.size(); ++m)
            if (const double volume_m3 = tree.memberVolume_m3(m, capacity_m3, shape, front_m);
                volume_m3 > 0.0)
                current_.push_back(
                    {std::uint32_t(grid.offset(tree.piece.voxel(m))), float(volume_m3 * per_m4)});
        mergeRegion();
    }
}

void ContrastPainter::collectStains(const Contrast& contrast) {
    const FrontShape& shape = contrast.settings().stain_front;
    for (std::size_t s = 0; s < balls_.size(); ++s) {
        const Stain& stain = contrast.stains()[s];
        const Ball& ball = balls_[s];
        const double front_m =
            ball.order.frontPosition_m(shape, std::min(stain.spread_m3, ball.order.total()));
        const double full_per_m = porosity(contrast.settings(), stain.kind) * stain.volume_m3 /
                                  stain.spread_m3 * voxelVolume_m3(contrast.patient().grid()) *
                                  attenuationPerVolume(contrast);
        for (std::size_t i = 0; i < ball.offsets.size(); ++i)
            if (const double share = shape.share(front_m, ball.path_m[i]); share > 0.0)
                current_.push_back({ball.offsets[i], float(full_per_m * share)});
        mergeRegion();
    }
}

void ContrastPainter::collectPlumes(const Contrast& contrast) {
    const Grid& grid = contrast.patient().grid();
    const double full_per_m = voxelVolume_m3(grid) * attenuationPerVolume(contrast);
    for (const Plume& plume : contrast.plumes()) {
        const VoxelPiece& piece = contrast.vessels()[plume.vessel].piece;
        for (std::size_t m = 0; m < piece.size(); ++m) {
            const std::size_t step = plume.step[m];
            if (step >= std::size_t(Plume::kSteps) || plume.volume_m3[step] <= 0.0) continue;
            const double share = plume.volume_m3[step] / plume.capacity_m3[step];
            current_.push_back({std::uint32_t(grid.offset(piece.voxel(m))), float(full_per_m * share)});
        }
        mergeRegion();
    }
}

// Merges the entries of current_ since the last call into the earlier ones. Both parts must be sorted by
// offset.
void ContrastPainter::mergeRegion() {
    const auto middle = current_.begin() + std::ptrdiff_t(region_);
    if (region_ > 0 && middle != current_.end()) {
        merged_.resize(current_.size());
        std::merge(current_.begin(), middle, middle, current_.end(), merged_.begin(),
                   [](const VoxelAttenuation& a, const VoxelAttenuation& b) { return a.offset < b.offset; });
        std::swap(current_, merged_);
    }
    region_ = current_.size();
}

// Lists every voxel that contains medium. Sums the entries of the same voxel, so that each voxel is listed
// once.
void ContrastPainter::collectAttenuation(const Contrast& contrast) {
    current_.clear();
    region_ = 0;
    collectDucts(contrast);
    collectStains(contrast);
    collectPlumes(contrast);
    std::size_t last = 0;
    for (std::size_t i = 1; i < current_.size(); ++i) {
        if (current_[i].offset == current_[last].offset)
            current_[last].added_per_m += current_[i].added_per_m;
        else
            current_[++last] = current_[i];
    }
    if (!current_.empty()) current_.resize(last + 1);
}

// Writes the differences between current_ and shown_, or all of current_ if the box has changed.
void ContrastPainter::writeChanges(const Grid& grid, ContrastChanges& changes) const {
    changes.offsets.clear(), changes.added_per_m.clear();
    const auto addChange = [&](std::uint32_t offset, float value) {
        changes.offsets.push_back(std::uint32_t(box_.offset(grid.voxelAt(offset) - low_)));
        changes.added_per_m.push_back(value);
    };
    auto before = changes.whole ? shown_.end() : shown_.begin();
    for (const VoxelAttenuation& entry : current_) {
        for (; before != shown_.end() && before->offset < entry.offset; ++before)
            addChange(before->offset, 0.0f);
        const bool there = before != shown_.end() && before->offset == entry.offset;
        if (!there || before->added_per_m != entry.added_per_m) addChange(entry.offset, entry.added_per_m);
        if (there) ++before;
    }
    for (; before != shown_.end(); ++before)
        addChange(before->offset, 0.0f);
}

void ContrastPainter::reset() {
    shown_state_.clear();
    low_ = Index3(0), high_ = Index3(-1);
}

bool ContrastPainter::paint(const Contrast& contrast, ContrastChanges& changes) {
    if (!hasVisibleChange(contrast)) {
        ++skipped_;
        return false;
    }
    growBalls(contrast);
    changes.whole = fitBox(contrast);
    changes.grid = box_;
    changes.revision = ++revision_;
    collectAttenuation(contrast);
    writeChanges(contrast.patient().grid(), changes);
    std::swap(current_, shown_);
    return true;
}

}  // namespace stylet::patient
