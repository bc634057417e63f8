#include "patient/contrast/contrast_table.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace stylet::patient {

namespace {

constexpr double kFirstReach_m = 0.008, kFurthestReach_m = 0.08, kFurther = 1.4;

}  // namespace

// Collects all volumes that the picture depends on and compares them with those of the last picture.
bool ContrastPainter::visiblyMoved(const Contrast& contrast) {
    std::vector<double> state;
    for (const DuctTree& tree : contrast.ducts())
        state.insert(state.end(), {tree.base_total_m3, tree.filled_m3});
    for (const Stain& stain : contrast.stains())
        state.insert(state.end(), {stain.spread_m3, stain.held_m3});
    for (const Plume& plume : contrast.plumes())
        state.insert(state.end(), plume.held_m3.begin(), plume.held_m3.end());
    double moved_m3 = state.size() == shown_state_.size() ? 0.0 : 2.0 * settings_.visible_m3;
    for (std::size_t i = 0; i < std::min(state.size(), shown_state_.size()); ++i)
        moved_m3 += std::fabs(state[i] - shown_state_[i]);
    if (state == shown_state_ || moved_m3 < settings_.visible_m3) return false;
    shown_state_ = std::move(state);
    return true;
}

// Enlarges the balls until they cover their stains.
void ContrastPainter::reachOut(const Contrast& contrast) {
    const Patient& patient = contrast.patient();
    const Grid& grid = patient.grid();
    const FrontShape& front = contrast.settings().stain_front;
    balls_.resize(contrast.stains().size());
    for (std::size_t s = 0; s < balls_.size(); ++s) {
        const Stain& stain = contrast.stains()[s];
        Ball& ball = balls_[s];
        const double room_m3 = porosity(contrast.settings(), stain.kind) * voxelVolume_m3(grid);
        const auto fits = [&] {
            if (ball.order.total() < stain.spread_m3) return false;
            const double front_m = ball.order.frontOf(front, stain.spread_m3);
            return front_m + 0.5 * front.widthAt(front_m) <= ball.reach_m;
        };
        while (ball.reach_m < kFurthestReach_m && !fits()) {
            ball.reach_m = std::max(kFirstReach_m, kFurther * ball.reach_m);
            const Index3 reach(Vec3(ball.reach_m) / grid.spacing_m + 1.0), at = grid.nearest(stain.centre_m);
            ball.low = glm::max(at - reach - 1, Index3(0));
            ball.high = glm::min(at + reach + 1, grid.dims - 1);
            ball.offsets.clear(), ball.path_m.clear();
            for (int z = ball.low.z; z <= ball.high.z; ++z)
                for (int y = ball.low.y; y <= ball.high.y; ++y)
                    for (int x = ball.low.x; x <= ball.high.x; ++x) {
                        const double path_m = glm::distance(grid.centre({x, y, z}), stain.centre_m);
                        if (path_m > ball.reach_m || stainKind(patient, {x, y, z}) != stain.kind) continue;
                        ball.offsets.push_back(std::uint32_t(grid.offset({x, y, z})));
                        ball.path_m.push_back(path_m);
                    }
            ball.order = FillOrder(ball.path_m, std::vector<double>(ball.path_m.size(), room_m3));
        }
    }
}

// Returns true if the box has changed.
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

namespace {

// Attenuation [1/m] of a voxel full of medium, divided by the voxel's volume.
double perVolume(const Contrast& contrast) {
    const ContrastSettings& s = contrast.settings();
    return s.iodine_kg_per_m3 * s.attenuation_m2_per_kg / voxelVolume_m3(contrast.patient().grid());
}

}  // namespace

void ContrastPainter::lightDucts(const Contrast& contrast) {
    const Grid& grid = contrast.patient().grid();
    const FrontShape& shape = contrast.settings().duct_front;
    const double per_m4 = perVolume(contrast);
    for (const DuctTree& tree : contrast.ducts()) {
        const double front_m = tree.order.frontOf(shape, tree.filled_m3);
        const double room_m3 = ductRoom_m3(contrast.settings(), tree.piece.box);
        for (std::size_t m = 0; m < tree.piece.size(); ++m)
            if (const double held_m3 = tree.heldBy(m, room_m3, shape, front_m); held_m3 > 0.0)
                now_.push_back({std::uint32_t(grid.offset(tree.piece.voxel(m))), float(held_m3 * per_m4)});
        endRegion();
    }
}

void ContrastPainter::lightStains(const Contrast& contrast) {
    const FrontShape& shape = contrast.settings().stain_front;
    for (std::size_t s = 0; s < balls_.size(); ++s) {
        const Stain& stain = contrast.stains()[s];
        const Ball& ball = balls_[s];
        const double front_m = ball.order.frontOf(shape, std::min(stain.spread_m3, ball.order.total()));
        const double full_per_m = porosity(contrast.settings(), stain.kind) * stain.held_m3 /
                                  stain.spread_m3 * voxelVolume_m3(contrast.patient().grid()) *
                                  perVolume(contrast);
        for (std::size_t i = 0; i < ball.offsets.size(); ++i)
            if (const double share = shape.share(front_m, ball.path_m[i]); share > 0.0)
                now_.push_back({ball.offsets[i], float(full_per_m * share)});
        endRegion();
    }
}

void ContrastPainter::lightPlumes(const Contrast& contrast) {
    const Grid& grid = contrast.patient().grid();
    const double full_per_m = voxelVolume_m3(grid) * perVolume(contrast);
    for (const Plume& plume : contrast.plumes()) {
        const VoxelPiece& piece = contrast.vessels()[plume.vessel].piece;
        for (std::size_t m = 0; m < piece.size(); ++m) {
            const std::size_t step = plume.step[m];
            if (step >= std::size_t(Plume::kSteps) || plume.held_m3[step] <= 0.0) continue;
            const double share = plume.held_m3[step] / plume.room_m3[step];
            now_.push_back({std::uint32_t(grid.offset(piece.voxel(m))), float(full_per_m * share)});
        }
        endRegion();
    }
}

// The entries since the last call are sorted by offset; merges them into the earlier ones.
void ContrastPainter::endRegion() {
    const auto middle = now_.begin() + std::ptrdiff_t(region_);
    if (region_ > 0 && middle != now_.end()) {
        merged_.resize(now_.size());
        std::merge(now_.begin(), middle, middle, now_.end(), merged_.begin(),
                   [](const Lit& a, const Lit& b) { return a.offset < b.offset; });
        std::swap(now_, merged_);
    }
    region_ = now_.size();
}

// Lists every voxel that contains medium exactly once.
void ContrastPainter::light(const Contrast& contrast) {
    now_.clear();
    region_ = 0;
    lightDucts(contrast);
    lightStains(contrast);
    lightPlumes(contrast);
    std::size_t last = 0;
    for (std::size_t i = 1; i < now_.size(); ++i) {
        if (now_[i].offset == now_[last].offset)
            now_[last].added_per_m += now_[i].added_per_m;
        else
            now_[++last] = now_[i];
    }
    if (!now_.empty()) now_.resize(last + 1);
}

// Lists the differences between now_ and shown_; everything in now_ if the box has changed.
void ContrastPainter::writeChanges(const Grid& grid, ContrastChanges& changes) const {
    changes.offsets.clear(), changes.added_per_m.clear();
    const auto nx = std::uint32_t(grid.dims.x), ny = std::uint32_t(grid.dims.y);
    const auto say = [&](std::uint32_t offset, float value) {
        const Index3 voxel{int(offset % nx), int(offset / nx % ny), int(offset / (nx * ny))};
        changes.offsets.push_back(std::uint32_t(box_.offset(voxel - low_)));
        changes.added_per_m.push_back(value);
    };
    auto before = changes.whole ? shown_.end() : shown_.begin();
    for (const Lit& lit : now_) {
        for (; before != shown_.end() && before->offset < lit.offset; ++before)
            say(before->offset, 0.0f);
        const bool there = before != shown_.end() && before->offset == lit.offset;
        if (!there || before->added_per_m != lit.added_per_m) say(lit.offset, lit.added_per_m);
        if (there) ++before;
    }
    for (; before != shown_.end(); ++before)
        say(before->offset, 0.0f);
}

void ContrastPainter::reset() {
    shown_state_.clear();
    low_ = Index3(0), high_ = Index3(-1);
}

bool ContrastPainter::paint(const Contrast& contrast, ContrastChanges& changes) {
    if (!visiblyMoved(contrast)) {
        ++skipped_;
        return false;
    }
    reachOut(contrast);
    changes.whole = fitBox(contrast);
    changes.grid = box_;
    changes.revision = ++revision_;
    light(contrast);
    writeChanges(contrast.patient().grid(), changes);
    std::swap(now_, shown_);
    return true;
}

}  // namespace stylet::patient
