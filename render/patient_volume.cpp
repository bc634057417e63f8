#include "render/patient_volume.h"

#include "render/classified.h"

namespace stylet::render {
namespace {

constexpr int kThreads = 2;
constexpr std::int16_t kBodyHu = -300;
constexpr double kBackShare = 0.02;  // of a coronal plane: less is noise, or the folds of a sheet

// The lowest coronal plane that a body lies in.
double backOf(const patient::Patient& patient) {
    const patient::CtVolume& ct = patient.package().ct;
    const patient::Index3 dims = ct.grid.dims;
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

GpuImage makeClassified(const Gpu& gpu, const patient::Index3& dims) {
    const auto limit = gpu.physicalDevice().getProperties().limits.maxImageDimension3D;
    if (std::uint32_t(std::max({dims.x, dims.y, dims.z})) > limit)
        throw GpuError("the volume is larger than a 3D image of this device (" + std::to_string(limit) + ")");
    return GpuImage(gpu, vk::Format::eR8G8B8A8Unorm,
                    {std::uint32_t(dims.x), std::uint32_t(dims.y), std::uint32_t(dims.z)}, 1,
                    vk::ImageUsageFlagBits::eSampled | vk::ImageUsageFlagBits::eTransferDst);
}

}  // namespace

PatientVolume::PatientVolume(const Gpu& gpu, const patient::Patient& patient)
    : gpu_(&gpu),
      patient_(&patient),
      back_m_(backOf(patient)),
      classified_(makeClassified(gpu, patient.grid().dims)),
      reference_(patient.grid().dims),
      rows_(breathRows(patient.package().breathing, patient.package().breathing.reference)) {
    const auto usage = vk::BufferUsageFlagBits::eStorageBuffer;
    brick_buffer_ = Buffer(gpu, reference_.occupied.size() * sizeof(std::uint32_t), usage);
    breath_buffer_ = Buffer(gpu, rows_.rows.size() * sizeof(gpu::BreathRow), usage);
}

void PatientVolume::show(const LookStyle& look) {
    if (shown_ == &look) return;
    const Palette palette = resolve(look, *patient_);
    const patient::Index3 dims = patient_->grid().dims;
    reference_ = BrickGrid(dims);
    uploadPlanes(*gpu_, classified_, 4, [&](int z0, int z1, std::byte* rgba) {
        classifyPlanes(*patient_, palette, z0, z1, rgba, kThreads);
        markOccupied(reference_, dims, z0, z1, rgba);
    });
    shown_ = &look;
    stale_ = true;
}

void PatientVolume::breathe(const patient::Surrogate& breath, bool still) {
    if (!stale_ && breath_ == breath && still_ == still) return;
    BrickGrid seen = reference_;
    if (!still) {
        rows_ = breathRows(patient_->package().breathing, breath);
        breath_buffer_.write(rows_.rows.data(), rows_.rows.size() * sizeof(gpu::BreathRow));
        seen = deformOccupancy(reference_, patient_->grid(), rows_);
    }
    const std::vector<std::uint32_t> leaps = leapDistances(seen);
    brick_buffer_.write(leaps.data(), leaps.size() * sizeof(std::uint32_t));
    breath_ = breath;
    still_ = still;
    stale_ = false;
}

}  // namespace stylet::render
