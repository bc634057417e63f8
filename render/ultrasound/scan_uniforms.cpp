#include "render/ultrasound/scan_uniforms.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/gtc/quaternion.hpp>

#include "render/scene/projection.h"

namespace stylet::render {
namespace {

constexpr double kMargin_pixels = 8.0, kRuler_pixels = 14.0;
// Gel fills air this much deeper than the computed contact, because the skin's position is known only to
// whole voxels.
constexpr double kExtraGel_m = 0.002;
constexpr double kTick_m = 0.01;
// In air a probe shows its own lens: some bands that fade within a centimetre. Values chosen by eye.
constexpr double kRingPeriod_m = 0.0016, kRingDecay_m = 0.004, kRingAmplitude = 0.09;

double amplitude(double db) {
    return std::exp(kNeperPerDb * db);
}

// The lattice of scatterers is rotated relative to the patient's axes and to every plane in which a probe is
// likely to scan.
glm::dmat3 latticeFromPatient() {
    return glm::mat3_cast(glm::normalize(glm::dquat(0.83, 0.31, -0.41, 0.22)));
}

gpu::AcousticUniforms acousticUniforms(const Acoustic& a, const ScanPlan& plan) {
    const double drawn_m = plan.step_m * kAssumedSpeed_m_per_s / a.speed_m_per_s;
    const double passes = std::exp(plan.amplified_np_per_m * drawn_m -
                                   plan.step_m * attenuation_np_per_m(a, plan.frequency_hz));
    return {
        {float(std::log(a.impedance_rayl)), float(passes), float(drawn_m), float(amplitude(a.scatter_db))},
        {float(std::log1p(a.impedance_by_hu)), float(kNeperPerDb * a.scatter_by_hu_db),
         float(a.wall_db ? amplitude(*a.wall_db) : 0.0), float(a.wall_db ? a.wall_m : 0.0)}};
}

}  // namespace

double attenuation_np_per_m(const Acoustic& a, double frequency_hz) {
    return 2.0 * kNeperPerDb * a.attenuation_db_per_m_mhz * frequency_hz * 1e-6;
}

PictureView pictureView(const Transducer& probe, const UltrasoundSettings& settings, double depth_m) {
    const ScanLine edge = scanLine(probe, 1.0);
    const double half_m = (edge.origin_m + depth_m * edge.direction).x, top_m = edge.origin_m.z;
    const double across = settings.width - 2.0 * (kMargin_pixels + kRuler_pixels);
    const double down = settings.height - 2.0 * kMargin_pixels;
    PictureView view;
    view.pixel_m = std::max(2.0 * half_m / std::max(across, 1.0), (depth_m - top_m) / std::max(down, 1.0));
    view.left_m = -0.5 * settings.width * view.pixel_m;
    view.top_m = top_m - kMargin_pixels * view.pixel_m;
    return view;
}

void fillUniforms(const ScanSetup& setup, const Grid& grid, gpu::ScanUniforms& u) {
    const auto& [plan, input, settings, probe, table] = setup;
    const Pose& patient_from_probe = *input.patient_from_probe;
    u.voxel_scale = toVec4(1.0 / grid.spacing_m, table.roughness);
    u.voxel_offset = toVec4(-grid.origin_m / grid.spacing_m, table.air);
    u.voxel_dims = toVec4(Vec3(grid.dims), table.gel);
    u.across = toVec4(patient_from_probe.direction({0, 1, 0}), 1.0 / kScatterers_m);
    const glm::dmat3 lattice = glm::transpose(latticeFromPatient());
    for (int i = 0; i < 3; ++i)
        u.lattice[i] = toVec4(lattice[i]);
    const double noise = settings.noise_db > -300.0 ? amplitude(settings.noise_db) : 0.0;
    u.march = {plan.step_m, plan.bin_m, noise, plan.amplified_np_per_m};
    for (std::size_t i = 0; i < plan.pulse.size(); ++i)
        u.pulse[i] = {plan.pulse[i], plan.mirror_scale, 0.0, 0.0};
    u.rings = {kRingPeriod_m, kRingDecay_m, kRingAmplitude, 0.0};
    u.tone = {settings.dynamic_range_db, 0.0, double(input.number % 65536), input.guide_m ? 1.0 : 0.0};
    for (std::size_t i = 0; i < plan.planes.size(); ++i)
        u.planes[i] = {plan.planes[i].sigmas, plan.planes[i].weight, 0.0, 0.0};
    u.probe = {probe.shape == TransducerShape::linear ? 1.0 : 0.0, probe.radius_m, probe.half_angle_rad,
               0.5 * probe.width_m};
    const PictureView view = pictureView(probe, settings, plan.depth_m);
    u.view = {view.pixel_m, view.left_m, view.top_m, plan.depth_m};
    u.guide = glm::vec4(0.0f);
    if (input.guide_m) {
        const Pose probe_from_patient = patient_from_probe.inverse();
        const Vec3 a = probe_from_patient * (*input.guide_m)[0], b = probe_from_patient * (*input.guide_m)[1];
        u.guide = {a.x, a.z, b.x, b.z};
    }
    u.marks = {plan.focus_m, kTick_m, settings.width, settings.height};
    const std::size_t depots = std::min(input.depots.size(), std::size_t(gpu::kMaxDepots));
    u.reach = {settings.reach_sigma, scattererCorrelation(plan.step_m),
               settings.gel_m > 0.0 ? kExtraGel_m : 0.0, double(depots)};
    for (std::size_t i = 0; i < depots; ++i)
        u.depots[i] = toVec4(input.depots[i].centre_reference_m, input.depots[i].radius_m);
    if (const auto& box = settings.doppler) {
        u.doppler = {box->from_share, box->to_share, box->from_m, box->to_m};
        u.flow_look = {box->wall_filter_m_per_s, amplitude(box->gain_db), kDopplerColumns, kDopplerRows};
    }
    u.dry = glm::uvec4(0u);
    for (std::size_t i = 0; i < table.acoustics.size(); ++i) {
        u.tissues[i] = acousticUniforms(table.acoustics[i], plan);
        if (table.acoustics[i].solid || int(i) == table.air) u.dry.x |= 1u << i;
    }
}

namespace {

// A straight part of a curved tube, which echoes like a needle without a ground tip.
struct TubePart {
    Pose probe_from_part;
    NeedleShape shape;
};

std::vector<TubePart> tubeParts(const UltrasoundInput& input, const Pose& probe_from_patient) {
    std::vector<TubePart> parts;
    for (const CurvedTube& tube : input.tubes)
        for (std::size_t i = 1; i < tube.points_m.size(); ++i) {
            const Vec3 begin = tube.points_m[i - 1], along = tube.points_m[i] - begin;
            const double length_m = glm::length(along);
            if (!(length_m > 0.0)) continue;
            TubePart part;
            const Vec3 z = along / length_m;
            const Vec3 x =
                glm::normalize(glm::cross(std::fabs(z.x) < 0.9 ? Vec3(1, 0, 0) : Vec3(0, 1, 0), z));
            const Quat turn = glm::normalize(glm::quat_cast(glm::dmat3(x, glm::cross(z, x), z)));
            part.probe_from_part = probe_from_patient * Pose{turn, begin};
            part.shape.outer_m = 2.0 * tube.radius_m;
            part.shape.length_m = length_m;
            part.shape.tip_echo = part.shape.shaft_echo;
            parts.push_back(part);
        }
    return parts;
}

}  // namespace

void fillLines(const ScanSetup& setup, const Contact& contact, gpu::LineUniforms* out) {
    const auto& [plan, input, settings, probe, table] = setup;
    const Pose& patient_from_probe = *input.patient_from_probe;
    const double glint =
        reflectivity(table.acoustics[std::size_t(table.gel)], table.acoustics[std::size_t(table.steel)]);
    std::array<NeedleEcho, kMaxLines> echoes{};
    const std::vector<TubePart> parts = tubeParts(input, patient_from_probe.inverse());
    std::optional<Pose> probe_from_needle;
    if (input.patient_from_needle)
        probe_from_needle = patient_from_probe.inverse() * *input.patient_from_needle;
    for (std::size_t l = 0; l < contact.lines.size(); ++l) {
        const LineContact& c = contact.lines[l];
        const ScanLine line = scanLine(probe, 2.0 * double(l) / double(settings.lines - 1) - 1.0);
        const bool marched = c.coupling > 0.0 || !settings.skips.lines_in_air;
        gpu::LineUniforms& u = out[l];
        u.origin = toVec4(patient_from_probe * line.origin_m, c.gel_m);
        u.direction = toVec4(patient_from_probe.direction(line.direction), marched ? c.coupling : -1.0);
        const double pitch = linePitch_m(probe, settings.lines, 0.5 * plan.depth_m);
        if (probe_from_needle)
            echoes[l] = needleEcho(probe, line, pitch, *probe_from_needle, input.needle, glint);
        for (const TubePart& part : parts) {
            const NeedleEcho echo = needleEcho(probe, line, pitch, part.probe_from_part, part.shape, glint);
            if (echo.amplitude > echoes[l].amplitude) echoes[l] = echo;
        }
    }
    spreadShadows(probe, {echoes.data(), contact.lines.size()});
    for (std::size_t l = 0; l < contact.lines.size(); ++l)
        out[l].needle = {echoes[l].depth_m, echoes[l].amplitude, echoes[l].shadow, input.needle.outer_m};
}

void fillDepths(const ScanPlan& plan, gpu::DepthUniforms* out) {
    for (const ScanPlan::Depth& d : plan.depths)
        *out++ = {{d.thickness_sigma_m, d.speckle, d.width_sigma_lines, d.gain}};
}

}  // namespace stylet::render
