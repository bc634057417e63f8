#include "render/volume/patient_volume.h"

#include <algorithm>

#include "base/parallel.h"
#include "render/volume/classified.h"

namespace stylet::render {
namespace {

constexpr std::int16_t kBodyHu = -300;
// A coronal plane contains body if at least this share of its voxels is denser than kBodyHu. A smaller share
// is noise or the folds of a sheet.
constexpr double kBackShare = 0.02;

// Returns the y coordinate [m] of the patient's back: the edge of the rearmost coronal plane that contains
// body.
double findBack(const patient::Patient& patient) {
    const CtVolume& ct = patient.package().ct;
    const Index3 dims = ct.grid.dims;
    const double needed = kBackShare * dims.x * dims.z;
    for (int y = 0; y < dims.y; ++y) {
        std::size_t body = 0;
        for (int z = 0; z < dims.z; ++z)
            for (int x = 0; x < dims.x; ++x)
                body += ct[{x, y, z}] > kBodyHu ? 1u : 0u;
        if (double(body) >= needed) return ct.grid.origin_m.y + (y - 0.5) * ct.grid.spacing_m.y;
    }
    return ct.grid.origin_m.y;
}

}  // namespace

PatientVolume::PatientVolume(const Gpu& gpu, const patient::Patient& patient, const DeformedPatient& deformed,
                             Reader reader)
    : gpu_(&gpu),
      patient_(&patient),
      deformed_(&deformed),
      back_m_(findBack(patient)),
      // Leaves cores for the other loops.
      workers_(std::max(2, processorCount() / 2)),
      brick_buffer_(gpu, BrickGrid(patient.grid().dims).occupied.size() * sizeof(std::uint32_t),
                    vk::BufferUsageFlagBits::eStorageBuffer),
      breathed_(BrickGrid(patient.grid().dims)) {
    if (reader == Reader::gpu)
        classified_ = makeVolumeImage(gpu, vk::Format::eR8G8B8A8Unorm, patient.grid().dims);
}

void PatientVolume::classify(const LookStyle& look) {
    const Palette palette = makePalette(look, *patient_);
    const Index3 dims = patient_->grid().dims;
    BrickGrid occupied(dims);
    const auto planes = [&](int z0, int z1, std::byte* rgba) {
        classifyPlanes(*patient_, palette, z0, z1, rgba, workers_.threads());
        markOccupied(occupied, dims, z0, z1, rgba);
    };
    if (reader_ == Reader::gpu) {
        if (!hasImage()) classified_ = makeVolumeImage(*gpu_, vk::Format::eR8G8B8A8Unorm, dims);
        uploadPlanes(*gpu_, classified_, 4, planes);
    } else {
        classifyOnHost(planes);
    }
    breathed_ = BreathingBricks(occupied);
    displaced_ = breathed_.occupancy();
}

void PatientVolume::classifyOnHost(const std::function<void(int, int, std::byte*)>& planes) {
    const Index3 dims = patient_->grid().dims;
    if (on_host_.dims() != dims) on_host_ = MarchVolume(dims);
    // Number of planes classified at once. Smoothing needs a few planes on each side, so neighbouring slabs
    // classify some planes twice.
    constexpr int kSlab = 128;
    std::vector<std::byte> slab(std::size_t(4 * kSlab) * std::size_t(dims.x) * std::size_t(dims.y));
    for (int z0 = 0; z0 < dims.z; z0 += kSlab) {
        const int z1 = std::min(z0 + kSlab, dims.z);
        planes(z0, z1, slab.data());
        on_host_.setPlanes(z0, z1, slab.data());
    }
}

bool PatientVolume::show(const LookStyle& look, Reader reader) {
    if (shown_ == &look && reader_ == reader) return false;
    const bool had_image = hasImage();
    reader_ = reader;
    classify(look);
    shown_ = &look;
    breath_revision_ = -1;
    return hasImage() != had_image;
}

void PatientVolume::updateForBreath() {
    if (breath_revision_ == deformed_->breathRevision()) return;
    if (deformed_->still())
        breathed_.resetToReference();
    else
        breathed_.update(patient_->grid(), deformed_->tables(), deformed_->reach_m(), workers_);
    breath_revision_ = deformed_->breathRevision();
    bricks_stale_ = true;
}

void PatientVolume::updateForTool() {
    const patient::DisplacementTable* table = deformed_->tool();
    if (!table && !pressed_ && !bricks_stale_) return;
    if (table) displaceOccupancy(breathed_.occupancy(), patient_->grid(), *table, displaced_);
    leapDistances(table ? displaced_ : breathed_.occupancy(), leaps_);
    brick_buffer_.write(leaps_.data(), leaps_.size() * sizeof(std::uint32_t));
    pressed_ = table != nullptr;
    bricks_stale_ = false;
}

void PatientVolume::updateBricks() {
    updateForBreath();
    updateForTool();
}

}  // namespace stylet::render
