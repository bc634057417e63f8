#include "patient/contrast/contrast.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/transcendental.h"

namespace stylet::patient {

namespace {

constexpr double kNegligible_m3 = 1e-15;  // a millionth of a microlitre; counts as zero
constexpr std::size_t kMaxStains = 256;
constexpr std::size_t kMaxPlumes = 32;

bool isDuct(const Label& label) {
    return label.tissue == Tissue::duct && label.role == Role::target;
}

LabelSet ductLabels(const Patient& patient) {
    LabelSet set{};
    for (const Label& label : patient.package().label_table)
        set[label.id] = isDuct(label);
    return set;
}

// Finds the blockage of the tree and its outlets into the bowel.
void findBlockageAndOutlets(const Patient& patient, DuctTree& tree) {
    const std::vector<double> wall_m = wallDistance_m(tree.piece);
    const auto blocks = [](const Label& l) {
        const bool closed_duct = l.tissue == Tissue::duct && !isDuct(l);
        return l.blocks_contrast || closed_duct;
    };
    const auto drains = [](const Label& l) { return l.drains_ducts; };
    double best = -1.0;
    bool blocked = false;
    for (std::size_t m = 0; m < tree.piece.size(); ++m) {
        const Index3 voxel = tree.piece.voxel(m);
        const bool at_block = touches(patient, voxel, blocks);
        blocked = blocked || at_block;
        if (touches(patient, voxel, drains)) tree.outlets.push_back(m);
        // Any contact with a blockage counts more than any width.
        const double score = wall_m[m] + (at_block ? 1.0 : 0.0);
        if (score > best) best = score, tree.blockage = m;
    }
    if (blocked) tree.outlets.clear();  // a blocked tree does not drain, even if it touches the bowel
}

// Freezes everything filled so far and starts a new injection at `root`.
void restartInjection(DuctTree& tree, std::size_t root, const ContrastSettings& settings) {
    const double capacity_m3 = ductCapacity_m3(settings, tree.piece.box);
    if (tree.filled_m3 > 0.0) {
        const double front_m = tree.order.frontPosition_m(settings.duct_front, tree.filled_m3);
        for (std::size_t m = 0; m < tree.piece.size(); ++m)
            tree.base_m3[m] = tree.memberVolume_m3(m, capacity_m3, settings.duct_front, front_m);
        tree.base_total_m3 += tree.filled_m3;
    }
    tree.root = root;
    const PathStart start{root, 0.0};
    tree.path_m = geodesic_m(tree.piece, {&start, 1});
    std::vector<double> left_m3(tree.piece.size());
    for (std::size_t m = 0; m < tree.piece.size(); ++m)
        left_m3[m] = std::max(0.0, capacity_m3 - tree.base_m3[m]);
    tree.order = FillOrder(tree.path_m, left_m3);
    tree.filled_m3 = 0.0;
}

// Moves the volume that exceeds a step's capacity to the next step. Returns the volume that leaves the last
// step, and so the vessel.
double pushOverflow(Plume& plume) {
    double pushed_m3 = 0.0;
    for (std::size_t k = 0; k < std::size_t(Plume::kSteps); ++k) {
        plume.volume_m3[k] += pushed_m3;
        pushed_m3 = std::max(0.0, plume.volume_m3[k] - plume.capacity_m3[k]);
        plume.volume_m3[k] -= pushed_m3;
    }
    return pushed_m3;
}

// Medium flows from the tip with the blood. Steps may lead slightly upstream, so that the medium spreads
// across the lumen.
Plume makePlume(const VesselTree& vessel, std::size_t index, std::size_t tip, const Vec3& tip_m) {
    constexpr double kBack = 0.1;
    const PathStart start{tip, 0.0};
    // The cost of a step is its travel time at the lumen's mean speed, not its length.
    const std::vector<double> time_s = geodesic_m(
        vessel.piece, {&start, 1},
        [&](std::size_t from, std::size_t to, const Neighbour& n) {
            const bool back = vessel.along_m[to] < vessel.along_m[from] - kBack * n.length_m;
            return back ? kUnreached_m
                        : 2.0 * n.length_m / (vessel.mean_m_per_s[from] + vessel.mean_m_per_s[to]);
        },
        Plume::kSteps * Plume::kStep_s);
    Plume plume;
    plume.vessel = index;
    plume.tip_m = tip_m;
    plume.step.assign(vessel.piece.size(), std::uint8_t(Plume::kSteps));
    for (std::size_t m = 0; m < vessel.piece.size(); ++m) {
        if (!std::isfinite(time_s[m])) continue;
        const auto step = std::min(int(time_s[m] / Plume::kStep_s), Plume::kSteps - 1);
        plume.step[m] = std::uint8_t(step);
        plume.capacity_m3[std::size_t(step)] += voxelVolume_m3(vessel.piece.box);
    }
    return plume;
}

}  // namespace

double porosity(const ContrastSettings& settings, Tissue kind) noexcept {
    if (kind == Tissue::liver) return settings.liver_porosity;
    return kind == Tissue::air ? settings.hollow_porosity : settings.soft_porosity;
}

double voxelVolume_m3(const Grid& grid) noexcept {
    return grid.spacing_m.x * grid.spacing_m.y * grid.spacing_m.z;
}

double ductCapacity_m3(const ContrastSettings& settings, const Grid& grid) noexcept {
    return (1.0 - settings.bile_share) * voxelVolume_m3(grid);
}

Tissue stainTissue(const Patient& patient, const Index3& voxel) noexcept {
    const TissueSample at = patient.at(voxel, {true, true});
    if (at.tissue == Tissue::liver || at.tissue == Tissue::vessel || at.tissue == Tissue::duct ||
        at.tissue == Tissue::air)
        return at.tissue;
    const Label* label = patient.label(at.label);
    if (label && label->drains_ducts) return Tissue::air;
    return Tissue::soft;
}

bool addToStains(std::vector<Stain>& stains, const StainGrowth& growth, Tissue kind, const Vec3& at_m,
                 double amount_m3) {
    constexpr double kBall = 4.18879020478639;  // 4 pi / 3
    Stain *near = nullptr, *any = nullptr;
    for (Stain& s : stains) {
        if (s.kind != kind) continue;
        any = &s;
        const double d = glm::distance(s.centre_m, at_m);
        const bool within = kBall * d * d * d * growth.porosity <= s.spread_m3;
        if (!near && (d <= growth.new_place_m || within)) near = &s;
    }
    if (!near && stains.size() < kMaxStains) near = &stains.emplace_back(Stain{kind, at_m});
    if (!near) near = any;
    if (!near) return false;
    near->spread_m3 += amount_m3;
    near->volume_m3 += amount_m3;
    return true;
}

double Plume::total() const {
    double sum_m3 = 0.0;
    for (const double step_m3 : volume_m3)
        sum_m3 += step_m3;
    return sum_m3;
}

Contrast::Contrast(const Patient& patient, const ContrastSettings& settings)
    : patient_(&patient), settings_(settings) {}

void Contrast::step(const ContrastInput& input, double dt_s) {
    const bool flows = input.rate_m3_per_s > 0.0;
    const double rate = flows ? std::min(input.rate_m3_per_s, settings_.max_m3_per_s) : 0.0;
    if (begun()) fade(dt_s);
    status_.rate_m3_per_s = rate;
    if (rate > 0.0) inject(input.tip_reference_m, input.inside, rate * dt_s);
    if (!begun()) return;
    updateVolumes();
    updateHash(input);
}

void Contrast::inject(const Vec3& tip_m, bool inside, double amount_m3) {
    ContrastVolumes& v = status_.volumes;
    v.injected_m3 += amount_m3;
    const Index3 voxel =
        isFinite(tip_m) && glm::dot(tip_m, tip_m) < 1e6 ? patient_->grid().nearest(tip_m) : Index3(-1);
    if (!inside || !patient_->grid().contains(voxel)) {
        status_.place = ContrastPlace::outside;
        v.lost_m3 += amount_m3;
        return;
    }
    const TissueSample at = patient_->at(voxel, {true, true});
    const Label* label = patient_->label(at.label);
    if (label && isDuct(*label)) return injectIntoDuct(tip_m, voxel, amount_m3);
    if (at.tissue == Tissue::vessel && label) return injectIntoVessel(tip_m, voxel, label->blood, amount_m3);
    const bool liver = at.tissue == Tissue::liver;
    status_.place = liver ? ContrastPlace::liver : ContrastPlace::elsewhere;
    const Tissue kind = stainTissue(*patient_, voxel);
    // A closed duct or a vessel without a label: the medium leaks into the surroundings.
    const bool tube = kind == Tissue::duct || kind == Tissue::vessel;
    addStain(tube ? Tissue::soft : kind, tip_m, amount_m3);
}

DuctTree& Contrast::findOrAddTree(const Index3& voxel) {
    for (DuctTree& tree : ducts_)
        if (tree.piece.at(voxel) != VoxelPiece::kNone) return tree;
    DuctTree& tree = ducts_.emplace_back();
    tree.piece = connectedPiece(patient_->package().labels, voxel, ductLabels(*patient_));
    tree.base_m3.assign(tree.piece.size(), 0.0);
    findBlockageAndOutlets(*patient_, tree);
    restartInjection(tree, std::size_t(tree.piece.at(voxel)), settings_);
    return tree;
}

void Contrast::injectIntoDuct(const Vec3& tip_m, const Index3& voxel, double amount_m3) {
    status_.place = ContrastPlace::duct;
    DuctTree& tree = findOrAddTree(voxel);
    const auto tip = std::size_t(tree.piece.at(voxel));
    if (glm::distance(tree.piece.centre(tip), tree.piece.centre(tree.root)) > settings_.new_place_m)
        restartInjection(tree, tip, settings_);
    const double into_tree_m3 = std::min(amount_m3, std::max(0.0, tree.order.total() - tree.filled_m3));
    const double front_m = tree.order.frontPosition_m(settings_.duct_front, tree.filled_m3 + into_tree_m3);
    const double capacity_m3 = ductCapacity_m3(settings_, tree.piece.box);
    status_.front_m = front_m;
    status_.tree_m3 = capacity_m3 * double(tree.piece.size());
    status_.blockage_reference_m = tree.piece.centre(tree.blockage);
    status_.at_blockage =
        tree.outlets.empty() &&
        tree.memberVolume_m3(tree.blockage, capacity_m3, settings_.duct_front, front_m) > 0.5 * capacity_m3;
    for (const std::size_t outlet : tree.outlets)
        if (front_m > tree.path_m[outlet]) {
            addStain(Tissue::air, tree.piece.centre(outlet), amount_m3);
            return;
        }
    tree.filled_m3 += into_tree_m3;
    if (amount_m3 > into_tree_m3) addStain(Tissue::liver, tip_m, amount_m3 - into_tree_m3);
}

Plume* Contrast::findOrAddPlume(const Vec3& tip_m, const Index3& voxel, BloodKind kind) {
    for (Plume& plume : plumes_)
        if (glm::distance(plume.tip_m, tip_m) <= settings_.new_place_m &&
            vessels_[plume.vessel].piece.at(voxel) != VoxelPiece::kNone)
            return &plume;
    if (kind == BloodKind::none || plumes_.size() >= kMaxPlumes) return nullptr;
    std::size_t vessel = 0;
    while (vessel < vessels_.size() && vessels_[vessel].piece.at(voxel) == VoxelPiece::kNone)
        ++vessel;
    if (vessel == vessels_.size())
        vessels_.push_back(
            makeVesselTree(*patient_, kind, connectedPiece(patient_->package().labels, voxel)));
    const VesselTree& tree = vessels_[vessel];
    plumes_.push_back(makePlume(tree, vessel, std::size_t(tree.piece.at(voxel)), tip_m));
    return &plumes_.back();
}

void Contrast::injectIntoVessel(const Vec3& tip_m, const Index3& voxel, BloodKind kind, double amount_m3) {
    status_.place = ContrastPlace::vessel;
    Plume* plume = findOrAddPlume(tip_m, voxel, kind);
    if (!plume) {  // in the heart, where the medium is washed out at once
        status_.volumes.washed_out_m3 += amount_m3;
        return;
    }
    plume->volume_m3[0] += amount_m3;
    status_.volumes.washed_out_m3 += pushOverflow(*plume);
}

void Contrast::addStain(Tissue kind, const Vec3& at_m, double amount_m3) {
    if (!addToStains(stains_, {porosity(settings_, kind), settings_.new_place_m}, kind, at_m, amount_m3))
        status_.volumes.lost_m3 += amount_m3;
}

void Contrast::fade(double dt_s) {
    if (dt_s != fade_dt_s_) {
        fade_dt_s_ = dt_s;
        stain_decay_ = detExp(-dt_s / settings_.stain_fade_s);
        plume_decay_ = detExp(-dt_s / settings_.vessel_washout_s);
    }
    for (Stain& stain : stains_) {
        if (stain.kind != Tissue::liver) continue;
        const double left_m3 = stain.volume_m3 > kNegligible_m3 ? stain.volume_m3 * stain_decay_ : 0.0;
        status_.volumes.washed_out_m3 += stain.volume_m3 - left_m3;
        stain.volume_m3 = left_m3;
    }
    for (Plume& plume : plumes_)
        flow(plume, dt_s);
    std::erase_if(plumes_, [](const Plume& plume) { return plume.total() == 0.0; });
}

void Contrast::flow(Plume& plume, double dt_s) {
    double& washed_out_m3 = status_.volumes.washed_out_m3;
    for (double& volume_m3 : plume.volume_m3) {
        const double left_m3 = volume_m3 > kNegligible_m3 ? volume_m3 * plume_decay_ : 0.0;
        washed_out_m3 += volume_m3 - left_m3;
        volume_m3 = left_m3;
    }
    plume.since_step_s += dt_s;
    if (plume.since_step_s < Plume::kStep_s) return;
    plume.since_step_s -= Plume::kStep_s;
    washed_out_m3 += plume.volume_m3.back();
    std::copy_backward(plume.volume_m3.begin(), plume.volume_m3.end() - 1, plume.volume_m3.end());
    plume.volume_m3.front() = 0.0;
    washed_out_m3 += pushOverflow(plume);
}

void Contrast::updateVolumes() {
    ContrastVolumes& v = status_.volumes;
    v.ducts_m3 = v.liver_m3 = v.vessels_m3 = v.pooled_m3 = 0.0;
    for (const DuctTree& tree : ducts_)
        v.ducts_m3 += tree.volume_m3();
    for (const Stain& stain : stains_)
        (stain.kind == Tissue::liver ? v.liver_m3 : v.pooled_m3) += stain.volume_m3;
    for (const Plume& plume : plumes_)
        v.vessels_m3 += plume.total();
}

void Contrast::updateHash(const ContrastInput& input) {
    const ContrastVolumes& v = status_.volumes;
    hash_.add(input.tip_reference_m);
    hash_.add(status_.rate_m3_per_s);
    hash_.add(std::uint64_t(status_.place));
    for (const double part : {v.injected_m3, v.ducts_m3, v.liver_m3, v.vessels_m3, v.pooled_m3,
                              v.washed_out_m3, v.lost_m3, status_.front_m})
        hash_.add(part);
}

void apply(const ContrastChanges& changes, ContrastTable& table) {
    if (changes.whole) {
        table.grid = changes.grid;
        table.added_per_m.assign(changes.grid.voxelCount(), 0.0f);
    }
    for (std::size_t i = 0; i < changes.offsets.size(); ++i)
        table.added_per_m[changes.offsets[i]] = changes.added_per_m[i];
    table.revision = changes.revision;
}

}  // namespace stylet::patient
