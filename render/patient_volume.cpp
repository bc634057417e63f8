#include "render/patient_volume.h"

#include <cstring>

#include <glm/gtc/packing.hpp>

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

GpuImage makeVolume(const Gpu& gpu, vk::Format format, const patient::Index3& dims) {
    const auto limit = gpu.physicalDevice().getProperties().limits.maxImageDimension3D;
    if (std::uint32_t(std::max({dims.x, dims.y, dims.z})) > limit)
        throw GpuError("the volume is larger than a 3D image of this device (" + std::to_string(limit) + ")");
    return GpuImage(gpu, format, {std::uint32_t(dims.x), std::uint32_t(dims.y), std::uint32_t(dims.z)}, 1,
                    vk::ImageUsageFlagBits::eSampled | vk::ImageUsageFlagBits::eTransferDst);
}

// Half floats: every device filters them, and 15 mm are held to 0.01 mm.
constexpr vk::Format kTableFormat = vk::Format::eR16G16B16A16Sfloat;

void upload(const Gpu& gpu, const GpuImage& image, const std::vector<glm::vec4>& table) {
    const std::size_t plane = std::size_t(image.extent.width) * image.extent.height;
    uploadPlanes(gpu, image, 8, [&](int z0, int z1, std::byte* out) {
        for (std::size_t i = std::size_t(z0) * plane; i < std::size_t(z1) * plane; ++i, out += 8) {
            const std::uint64_t texel = glm::packHalf4x16(table[i]);
            std::memcpy(out, &texel, sizeof texel);
        }
    });
}

}  // namespace

PatientVolume::PatientVolume(const Gpu& gpu, const patient::Patient& patient)
    : gpu_(&gpu),
      patient_(&patient),
      back_m_(backOf(patient)),
      tables_(deformTables(patient.package().motion, patient.package().motion.reference)),
      classified_(makeVolume(gpu, vk::Format::eR8G8B8A8Unorm, patient.grid().dims)),
      inside_(makeVolume(gpu, kTableFormat, tables_.grid.dims)),
      outside_(makeVolume(gpu, kTableFormat, tables_.grid.dims)),
      brick_buffer_(gpu, BrickGrid(patient.grid().dims).occupied.size() * sizeof(std::uint32_t),
                    vk::BufferUsageFlagBits::eStorageBuffer),
      reference_(patient.grid().dims) {
    uploadTables();
}

void PatientVolume::uploadTables() {
    upload(*gpu_, inside_, tables_.inside);
    upload(*gpu_, outside_, tables_.outside);
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
        if (breath_ != breath || still_) {
            tables_ = deformTables(patient_->package().motion, breath);
            uploadTables();
        }
        seen = deformOccupancy(reference_, patient_->grid(), tables_);
    }
    const std::vector<std::uint32_t> leaps = leapDistances(seen);
    brick_buffer_.write(leaps.data(), leaps.size() * sizeof(std::uint32_t));
    breath_ = breath;
    still_ = still;
    stale_ = false;
}

}  // namespace stylet::render
