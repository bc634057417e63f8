#include "render/fluoroscopy/fluoroscopy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "patient/contrast/contrast.h"
#include "render/fluoroscopy/ray_pass.h"
#include "render/fluoroscopy/screen_pass.h"

namespace stylet::render {
namespace {

constexpr int kMaxPixels = 2048;
constexpr int kBlackPixels = 64;       // size of the black picture if the requested size is invalid
constexpr double kMeteredShare = 0.6;  // metered share of the open field, along either axis
constexpr double kTissueHu = -300.0;
constexpr double kFarthestInRoom_m = 1e4;              // positions beyond this are rejected
constexpr double kMinStep_m = 1e-4, kMaxStep_m = 1.0;  // finer steps would take too long

bool isInRoom(const Vec3& v) {
    return std::fabs(v.x) < kFarthestInRoom_m && std::fabs(v.y) < kFarthestInRoom_m &&
           std::fabs(v.z) < kFarthestInRoom_m;
}
bool isInRoom(const Pose& pose) {
    const Quat& q = pose.rotation;
    const double norm = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
    return isInRoom(pose.position_m) && std::fabs(norm - 1.0) < 1e-3;
}
template <typename... Values>
bool allPositive(Values... values) {
    return ((std::isfinite(values) && values > 0.0) && ...);
}

std::string_view badSettings(const FluoroscopySettings& s) {
    if (s.pixels < 1) return "the detector has no pixels";
    if (s.pixels > kMaxPixels) return "the detector has more than 2048 pixels a side";
    if (!allPositive(s.detector_m, s.pulse_rate_hz, s.curve, s.dose.detector_kerma_gy,
                     s.dose.max_kerma_gy_per_s, s.dose.max_kerma_gy_per_pulse) ||
        !std::isfinite(s.electronic_quanta) || !std::isfinite(s.flattening) ||
        !std::isfinite(s.dose.min_kerma_gy_per_s))
        return "a setting is not a positive number";
    for (const double step_m : {s.voxel_m, s.step_m, s.segment_m})
        if (!(step_m >= kMinStep_m && step_m <= kMaxStep_m)) return "a step is not between 0.1 mm and 1 m";
    if (!(s.beyond_ends_m >= 0.0 && s.beyond_ends_m <= 1.0)) return "the patient is longer than one metre";
    if (s.block != 1 && s.block != 2 && s.block != 4) return "a block has 1, 2 or 4 rays a side";
    return {};
}

std::string_view badInput(const FluoroscopyInput& input) {
    if (!std::isfinite(input.arm.orbital_rad) || !std::isfinite(input.arm.angulation_rad))
        return "the C-arm's angle is not a number";
    if (!isInRoom(input.patient_from_isocentre)) return "the C-arm's place is not a pose";
    if (!std::isfinite(input.time_s) || std::fabs(input.time_s) > 1e9) return "the time is not a time";
    const Collimation& c = input.collimation;
    for (const double blade : {c.left_m, c.right_m, c.up_m, c.down_m, c.iris_m.value_or(1.0)})
        if (!std::isfinite(blade)) return "a blade's place is not a number";
    if (c.iris_m && *c.iris_m <= 0.0) return "the collimator is closed";
    for (const XrayShape& s : input.shapes)
        if (!isInRoom(s.begin_m) || !isInRoom(s.end_m) || !allPositive(s.radius_m) ||
            !std::isfinite(s.bore_m) || !std::isfinite(s.per_m))
            return "an instrument's place is not a number";
    if (input.contrast && !input.contrast->added_per_m.empty() &&
        (input.contrast->added_per_m.size() != input.contrast->grid.voxelCount() ||
         glm::any(glm::lessThan(input.contrast->grid.dims, Index3(2)))))
        return "the contrast does not fill its box";
    return {};
}

bool inTissue(const DeformedPatient& patient, const Vec3& p) {
    const Vec3 reference = patient.still() ? p : referenceFromTables(patient.tables(), p);
    return double(patient.patient().package().ct.nearestOr(reference, -1000)) > kTissueHu;
}

std::string_view badGeometry(const DeformedPatient& patient, const Beam& beam) {
    if (glm::any(glm::lessThan(patient.patient().grid().dims, Index3(2)))) return "there is no patient";
    if (inTissue(patient, beam.source_m)) return "the X-ray source is inside the patient";
    if (inTissue(patient, beam.detector_m)) return "the detector is inside the patient";
    return {};
}

}  // namespace

struct Fluoroscopy::Impl {
    const Gpu& gpu;
    DeformedPatient& patient;
    Commands commands;
    RayPass rays;
    ScreenPass screen;
    std::int64_t pulse = -1;
    bool black = true;  // the black picture is shown
    std::array<float, std::size_t(gpu::kMeter* gpu::kMeter)> metered{};
    int pixels = 0;

    Impl(const Gpu& g, DeformedPatient& p) : gpu(g), patient(p), commands(g), rays(g, p), screen(g) {}

    FluoroscopyStats refuse(std::string_view reason, int wanted_pixels) {
        screen.showBlack(wanted_pixels < 1 || wanted_pixels > kMaxPixels ? kBlackPixels : wanted_pixels);
        black = true;
        pulse = -1;
        FluoroscopyStats stats;
        stats.reason = reason;
        return stats;
    }
    std::span<const float> meteredField(const Collimation&, const FluoroscopySettings&);
    FluoroscopyStats expose(const Beam&, const FluoroscopyInput&, const FluoroscopySettings&,
                            std::int64_t now);
};

// Copies the line integrals in the middle of the open field.
std::span<const float> Fluoroscopy::Impl::meteredField(const Collimation& c, const FluoroscopySettings& s) {
    const double half = 0.5 * s.detector_m;
    const double left = std::max(-c.left_m, -half), right = std::min(c.right_m, half);
    const double top = std::max(-c.up_m, -half), bottom = std::min(c.down_m, half);
    const int stride = gpu::meterStride(s.pixels), side = gpu::meterSide(s.pixels);
    const double pixel_m = s.detector_m / s.pixels;
    std::size_t count = 0;
    for (int row = 0; row < side; ++row)
        for (int column = 0; column < side; ++column) {
            const double x = (column * stride + 0.5) * pixel_m - half,
                         y = (row * stride + 0.5) * pixel_m - half;
            if (std::fabs(2.0 * x - left - right) < kMeteredShare * (right - left) + pixel_m &&
                std::fabs(2.0 * y - top - bottom) < kMeteredShare * (bottom - top) + pixel_m)
                metered[count++] = rays.meter()[std::size_t(row * gpu::kMeter + column)];
        }
    return {metered.data(), count};
}

FluoroscopyStats Fluoroscopy::Impl::expose(const Beam& beam, const FluoroscopyInput& input,
                                           const FluoroscopySettings& settings, std::int64_t now) {
    const bool wrote_contrast = rays.prepare(input, settings);
    screen.prepare(rays.paths(), settings.pixels);
    commands.submitAndWait(
        [&](const vk::raii::CommandBuffer& buffer) { rays.record(buffer, beam, input, settings); });
    FluoroscopyStats stats;
    stats.live = true;
    stats.exposure =
        computeExposure(meteredTransmission(meteredField(input.collimation, settings)), input.collimation,
                        settings.detector_m, settings.pixels, settings.pulse_rate_hz, settings.dose);
    screen.setTone(rays.meter(), gpu::meterSide(settings.pixels));
    commands.submitAndWait([&](const vk::raii::CommandBuffer& buffer) {
        screen.record(buffer, stats.exposure, input.collimation, settings, now);
    });
    stats.still_pictures = patient.still();
    stats.idle_tool_pictures = !patient.tool() && settings.skips.idle_tool;
    stats.unchanged_contrast = !wrote_contrast;
    if (settings.count) {
        const gpu::XrayCounters& c = rays.counters();
        stats.samples = std::uint64_t(c.samples_high) << 32 | c.samples;
        stats.empty_segments = c.empty_segments;
        stats.collimated_rays = c.collimated_rays;
    }
    return stats;
}

Fluoroscopy::Fluoroscopy(const Gpu& gpu, DeformedPatient& patient)
    : impl_(std::make_unique<Impl>(gpu, patient)) {}
Fluoroscopy::~Fluoroscopy() = default;

FluoroscopyStats Fluoroscopy::image(const FluoroscopyInput& input, const FluoroscopySettings& settings) {
    Impl& self = *impl_;
    FluoroscopyStats kept;
    kept.pulse = self.pulse;
    kept.last_image_held = !self.black;
    if (!input.pedal) {
        if (self.screen.pixels() == 0) kept = self.refuse("the pedal has not been pressed", settings.pixels);
        kept.pedal_up = 1;
        return kept;
    }
    std::string_view reason = badSettings(settings);
    if (reason.empty()) reason = badInput(input);
    if (!reason.empty()) return self.refuse(reason, settings.pixels);
    const std::int64_t now = std::int64_t(std::floor(input.time_s * settings.pulse_rate_hz + 1e-6));
    if (!self.black && now == self.pulse && settings.skips.between_pulses) {
        kept.reused_pulses = 1;
        return kept;
    }
    const Beam beam = makeBeam(input.arm, input.patient_from_isocentre);
    reason = badGeometry(self.patient, beam);
    if (reason.empty() && openArea_m2(input.collimation, settings.detector_m) <= 0.0)
        reason = "the collimator is closed";
    if (!reason.empty()) return self.refuse(reason, settings.pixels);
    FluoroscopyStats stats = self.expose(beam, input, settings, now);
    self.black = false;
    self.pixels = settings.pixels;
    stats.pulse = self.pulse = now;
    return stats;
}

ScreenPicture Fluoroscopy::picture() const {
    return impl_->screen.picture();
}

std::span<const float> Fluoroscopy::paths() const {
    const std::size_t side = std::size_t(impl_->pixels);
    return {static_cast<const float*>(impl_->rays.paths().mapped), side * side};
}

}  // namespace stylet::render
