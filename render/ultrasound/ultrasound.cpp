#include "render/ultrasound/ultrasound.h"

#include <algorithm>
#include <cstring>

#include "patient/contrast/vessel_flow.h"
#include "render/gpu/descriptors.h"
#include "render/gpu/image_states.h"
#include "render/gpu/pipelines.h"
#include "render/shaders.h"
#include "render/ultrasound/acoustic_volume.h"
#include "render/ultrasound/scan_uniforms.h"
#include "render/volume/deformed_patient.h"

namespace stylet::render {
namespace {

// Binding numbers, as in bindings.glsl.
enum class ScanBinding : std::uint32_t {
    scan,
    voxels,
    deform_inside,
    deform_outside,
    tool_moved,
    flow,
    lines,
    depths,
    places,
    samples,
    field,
    propagation,
    envelope,
    grey,
    doppler,
    picture
};
constexpr auto kScanBindings = [] {
    std::array<vk::DescriptorType, 16> types;
    types.fill(vk::DescriptorType::eStorageBuffer);
    types[0] = vk::DescriptorType::eUniformBuffer;
    std::fill_n(&types[std::size_t(ScanBinding::voxels)], 5, vk::DescriptorType::eCombinedImageSampler);
    return types;
}();
constexpr int kGroup = 64, kLanes = 8, kTile = 8;
constexpr auto kStorageUse = vk::BufferUsageFlagBits::eStorageBuffer;
// Shared memory of line.comp in bytes: per sample, and the rest.
constexpr std::uint32_t kSharedBytesPerSample = 16, kSharedBytesFixed = 600;

GpuImage makeVoxels(const Gpu& gpu, const patient::Patient& patient, const AcousticTable& table) {
    GpuImage image = makeVolumeImage(gpu, vk::Format::eR32Uint, patient.grid().dims);
    Workers workers;
    const AcousticEncoder encoder(patient, table, workers);
    uploadPlanes(gpu, image, sizeof(std::uint32_t), [&](int z0, int z1, std::byte* out) {
        encoder.encode(z0, z1, reinterpret_cast<std::uint32_t*>(out));
    });
    return image;
}

// Specialisation constants of bindings.glsl, and whether lines are computed serially.
using ScanFeatures = std::array<std::uint32_t, 9>;

struct Passes {
    ScanFeatures features{};
    vk::raii::Pipeline places = nullptr, tissue = nullptr, line = nullptr, serial = nullptr, spread = nullptr,
                       doppler = nullptr, picture = nullptr;
};

// True if the settings differ at most in gains and freeze.
bool samePlan(const UltrasoundSettings& a, UltrasoundSettings b) {
    b.gain_db = a.gain_db;
    b.tgc_db = a.tgc_db;
    b.dynamic_range_db = a.dynamic_range_db;
    b.freeze = a.freeze;
    return a == b;
}

constexpr std::string_view kNoContact = "the probe does not touch the skin";
constexpr std::string_view kInBone = "the probe is inside bone";
constexpr std::string_view kTooManySamples = "so many samples exceed the device's memory";

}  // namespace

struct Ultrasound::Impl {
    const Gpu& gpu;
    DeformedPatient& patient;
    AcousticTable table;
    std::array<int, 256> label_rows;
    GpuImage voxels, flow;
    vk::raii::Sampler nearest, clamped;
    Descriptors descriptors;
    Commands commands;
    std::vector<Passes> compiled;
    Buffer scan, lines, depths, places, samples, field, propagation, envelope, grey, doppler, pixels;
    gpu::ScanUniforms uniforms{};
    ScanPlan plan;
    Contact contact;
    UltrasoundSettings planned;  // settings of `plan`
    Transducer planned_probe;
    bool has_flow = false;
    Grid flow_grid;
    double flow_scale_m_per_s = 1.0;
    ScanFeatures scanned_features{};
    int reserved_images = -1;
    bool has_plan = false, has_scan = false, stale_bindings = true;
    int width = 0, height = 0;
    std::uint64_t revision = 0;

    Impl(const Gpu& g, DeformedPatient& p, const AcousticTable& t)
        : gpu(g),
          patient(p),
          table(t),
          label_rows(acousticsByLabel(table, p.patient())),
          voxels(makeVoxels(g, p.patient(), table)),
          flow(makeFilledVolume(g, vk::Format::eR16G16B16A16Sint, Index3(2), 8,
                                std::array<std::int16_t, 32>{}.data())),
          nearest(makeSampler(g, vk::Filter::eNearest, vk::SamplerAddressMode::eClampToEdge)),
          clamped(makeSampler(g, vk::Filter::eLinear, vk::SamplerAddressMode::eClampToEdge)),
          descriptors(g, kScanBindings, {}),
          commands(g),
          scan(g, sizeof(gpu::ScanUniforms), vk::BufferUsageFlagBits::eUniformBuffer),
          doppler(makeDeviceBuffer(g, sizeof(glm::vec2) * kDopplerColumns * kDopplerRows, kStorageUse)) {}

    void reserve(Buffer& buffer, std::size_t bytes, bool on_host) {
        if (buffer.size >= bytes) return;
        buffer = on_host ? Buffer(gpu, bytes, kStorageUse) : makeDeviceBuffer(gpu, bytes, kStorageUse);
        stale_bindings = true;
    }
    void reserveFor(const UltrasoundSettings&);
    void bindAll();
    const Passes& passesFor(const ScanFeatures&);
    ScanFeatures requiredFeatures(const UltrasoundSettings&) const;
    bool serial(const UltrasoundSettings& s) const {
        return s.path == ScanPath::serial || (s.path == ScanPath::automatic && gpu.isSoftware());
    }
    void black();
    // Returns the reason why nothing can be scanned; empty if a scan is possible.
    std::string_view prepare(const UltrasoundInput&, const UltrasoundSettings&, const Transducer&,
                             UltrasoundStats&);
    void setPatientUniforms(const UltrasoundInput&);
    void updateGains(const UltrasoundSettings&);
    void record(const vk::raii::CommandBuffer&, const Passes&, bool scanned) const;
    void count(const ScanFeatures&, UltrasoundStats&) const;
};

void Ultrasound::Impl::reserveFor(const UltrasoundSettings& s) {
    const std::size_t bins = std::size_t(s.lines) * std::size_t(s.samples);
    const std::size_t rows = std::size_t(s.lines) + 2, columns = std::size_t(s.samples) + 2;
    reserve(lines, sizeof(gpu::LineUniforms) * std::size_t(s.lines), true);
    reserve(depths, sizeof(gpu::DepthUniforms) * std::size_t(s.samples), true);
    const std::size_t line_step = std::size_t(std::max(s.place_samples / 2, 1));
    const std::size_t place_count =
        s.place_samples > 1 ? (rows / line_step + 2) * (columns / std::size_t(s.place_samples) + 2) : 1;
    reserve(places, sizeof(glm::vec4) * place_count * std::size_t(s.planes), false);
    reserve(samples, serial(s) ? 16 : 16 * bins * std::size_t(s.planes), false);
    reserve(field, sizeof(std::uint32_t) * bins, false);
    reserve(propagation, sizeof(glm::vec2) * (s.doppler ? bins : 1), false);
    reserve(envelope, sizeof(float) * bins, true);
    reserve(grey, sizeof(float) * bins, false);
    reserve(pixels, 4 * std::size_t(s.width) * std::size_t(s.height), true);
}

void Ultrasound::Impl::bindAll() {
    if (!stale_bindings && reserved_images == patient.imageRevision()) return;
    descriptors.bind(ScanBinding::scan, scan);
    descriptors.bind(ScanBinding::voxels, voxels, nearest);
    descriptors.bind(ScanBinding::deform_inside, patient.inside(), clamped);
    descriptors.bind(ScanBinding::deform_outside, patient.outside(), clamped);
    descriptors.bind(ScanBinding::tool_moved, patient.toolMoved(), clamped);
    descriptors.bind(ScanBinding::flow, flow, nearest);
    const std::pair<ScanBinding, const Buffer*> stores[] = {
        {ScanBinding::lines, &lines},       {ScanBinding::depths, &depths},
        {ScanBinding::places, &places},     {ScanBinding::samples, &samples},
        {ScanBinding::field, &field},       {ScanBinding::propagation, &propagation},
        {ScanBinding::envelope, &envelope}, {ScanBinding::grey, &grey},
        {ScanBinding::doppler, &doppler},   {ScanBinding::picture, &pixels}};
    for (const auto& [binding, buffer] : stores)
        descriptors.bind(binding, *buffer);
    descriptors.update();
    reserved_images = patient.imageRevision();
    stale_bindings = false;
}

ScanFeatures Ultrasound::Impl::requiredFeatures(const UltrasoundSettings& s) const {
    const bool breathes = !patient.still();
    const bool pressed = patient.tool();
    return {
        std::uint32_t(s.samples),       std::uint32_t(s.lines), std::uint32_t(s.planes),    breathes, pressed,
        std::uint32_t(s.place_samples), s.doppler && has_flow,  std::uint32_t(plan.taps()), serial(s)};
}

const Passes& Ultrasound::Impl::passesFor(const ScanFeatures& features) {
    for (const Passes& p : compiled)
        if (p.features == features) return p;
    const auto make = [&](std::span<const std::uint32_t> shader) {
        return makeComputePipeline(gpu, descriptors.layout(), shader, std::span(features).first(8));
    };
    Passes p;
    p.features = features;
    p.places = make(shaders::kUltrasoundPlaces);
    if (serial(planned)) {
        p.serial = make(shaders::kUltrasoundSerial);
    } else {
        p.tissue = make(shaders::kUltrasoundTissue);
        p.line = make(shaders::kUltrasoundLine);
    }
    p.spread = make(shaders::kUltrasoundSpread);
    p.doppler = make(shaders::kUltrasoundDoppler);
    p.picture = make(shaders::kUltrasoundPicture);
    compiled.push_back(std::move(p));
    return compiled.back();
}

void Ultrasound::Impl::black() {
    auto* rgba = static_cast<std::uint8_t*>(pixels.mapped);
    for (std::size_t i = 0; i < std::size_t(width) * std::size_t(height); ++i) {
        constexpr std::uint8_t kBlack[4] = {0, 0, 0, 255};
        std::memcpy(rgba + 4 * i, kBlack, 4);
    }
    has_scan = false;
    ++revision;
}

std::string_view Ultrasound::Impl::prepare(const UltrasoundInput& input, const UltrasoundSettings& settings,
                                           const Transducer& probe, UltrasoundStats& stats) {
    const std::string_view reason = noScanReason(input, settings, probe);
    // If the requested size is invalid, the last picture's size is kept.
    const bool sized =
        settings.width >= 16 && settings.width <= 4096 && settings.height >= 16 && settings.height <= 4096;
    width = sized ? settings.width : std::max(width, 16);
    height = sized ? settings.height : std::max(height, 16);
    reserve(pixels, 4 * std::size_t(width) * std::size_t(height), true);
    if (!reason.empty()) return reason;
    const auto limits = gpu.physicalDevice().getProperties().limits;
    if (!serial(settings)) {
        const std::uint64_t bins = std::uint64_t(settings.lines) * std::uint64_t(settings.samples);
        if (kSharedBytesPerSample * std::uint32_t(settings.samples) + kSharedBytesFixed >
                limits.maxComputeSharedMemorySize ||
            16 * bins * std::uint64_t(settings.planes) > limits.maxStorageBufferRange)
            return kTooManySamples;
    }
    if (has_plan && planned_probe == probe && samePlan(planned, settings)) {
        planned = settings;
        setGains(plan, settings);
    } else {
        plan = makeScanPlan(probe, settings);
        planned = settings;
        planned_probe = probe;
        has_plan = true;
        reserveFor(settings);
    }
    findContact(probe, settings, *input.patient_from_probe, {patient, table, label_rows}, contact);
    stats.contact = contact.share;
    if (contact.in_bone) return kInBone;
    if (contact.share == 0.0) return kNoContact;
    const ScanSetup setup{plan, input, settings, probe, table};
    fillUniforms(setup, patient.patient().grid(), uniforms);
    setPatientUniforms(input);
    scan.write(&uniforms, sizeof uniforms);
    fillLines(setup, contact, static_cast<gpu::LineUniforms*>(lines.mapped));
    fillDepths(plan, static_cast<gpu::DepthUniforms*>(depths.mapped));
    return {};
}

void Ultrasound::Impl::setPatientUniforms(const UltrasoundInput& input) {
    setMotion(uniforms, patient);
    if (!has_flow || !planned.doppler) return;
    uniforms.flow_scale = {glm::vec3(1.0 / flow_grid.spacing_m), float(flow_scale_m_per_s)};
    uniforms.flow_offset = {glm::vec3(-flow_grid.origin_m / flow_grid.spacing_m),
                            float(planned.doppler->nyquist_m_per_s)};
    uniforms.flow_dims = {glm::vec3(flow_grid.dims), 0.0f};
    for (int kind = 0; kind < patient::kBloodKindCount; ++kind)
        uniforms.pulses[kind / 4][kind % 4] = float(pulse(patient::BloodKind(kind), input.time_s));
}

// Redraws the last scan with other gains.
void Ultrasound::Impl::updateGains(const UltrasoundSettings& settings) {
    planned.gain_db = settings.gain_db;
    planned.tgc_db = settings.tgc_db;
    planned.dynamic_range_db = settings.dynamic_range_db;
    setGains(plan, planned);
    fillDepths(plan, static_cast<gpu::DepthUniforms*>(depths.mapped));
    uniforms.tone.x = float(planned.dynamic_range_db);
    scan.write(&uniforms, sizeof uniforms);
}

void Ultrasound::Impl::count(const ScanFeatures& features, UltrasoundStats& stats) const {
    for (const LineContact& c : contact.lines)
        stats.skipped_lines += planned.skips.lines_in_air && c.coupling == 0.0 ? 1u : 0u;
    const std::uint64_t a_line = std::uint64_t(planned.samples) * std::uint64_t(planned.planes);
    stats.samples = (contact.lines.size() - stats.skipped_lines) * a_line;
    const bool deformed = features[3] || features[4];
    const auto shared = std::uint64_t(planned.place_samples);
    stats.still_pictures = deformed ? 0 : 1;
    if (deformed)
        stats.look_ups =
            shared == 1 ? stats.samples
                        : contact.lines.size() * a_line / (shared * std::max<std::uint64_t>(shared / 2, 1));
}

void Ultrasound::Impl::record(const vk::raii::CommandBuffer& to, const Passes& p, bool scanned) const {
    const UltrasoundSettings& s = planned;
    descriptors.use(to, vk::PipelineBindPoint::eCompute);
    const auto pass = [&](const vk::raii::Pipeline& pipeline, std::uint32_t x, std::uint32_t y,
                          std::uint32_t z) {
        to.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline);
        to.dispatch(x, y, z);
        memoryBarrier(to, kComputeWrites,
                      {vk::PipelineStageFlagBits2::eComputeShader,
                       vk::AccessFlagBits2::eShaderStorageRead | vk::AccessFlagBits2::eShaderStorageWrite});
    };
    const auto line_count = std::uint32_t(s.lines), plane_count = std::uint32_t(s.planes);
    if (scanned) {
        const bool deformed = p.features[3] || p.features[4];
        if (deformed && s.place_samples > 1)
            pass(p.places, groupCount(s.samples / s.place_samples + 2, kGroup),
                 groupCount(s.lines, std::max(s.place_samples / 2, 1)) + 1, plane_count);
        if (*p.serial) {
            pass(p.serial, groupCount(s.lines, kLanes), 1, 1);
        } else {
            pass(p.tissue, groupCount(s.samples, kGroup), line_count, plane_count);
            pass(p.line, line_count, 1, 1);
        }
        if (p.features[6]) pass(p.doppler, groupCount(kDopplerRows, kGroup), kDopplerColumns, 1);
    }
    pass(p.spread, groupCount(s.samples, kGroup), line_count, 1);
    pass(p.picture, groupCount(width, kTile), groupCount(height, kTile), 1);
    memoryBarrier(to, kComputeWrites, kHostReads);
}

Ultrasound::Ultrasound(const Gpu& gpu, DeformedPatient& patient, const AcousticTable& table)
    : impl_(std::make_unique<Impl>(gpu, patient, table)) {}
Ultrasound::~Ultrasound() = default;
Ultrasound::Ultrasound(Ultrasound&&) noexcept = default;
Ultrasound& Ultrasound::operator=(Ultrasound&&) noexcept = default;

UltrasoundStats Ultrasound::image(const UltrasoundInput& input, const UltrasoundSettings& settings,
                                  const Transducer& probe) {
    Impl& m = *impl_;
    UltrasoundStats stats;
    const bool frozen = settings.freeze && m.has_scan;
    if (!frozen) stats.reason = m.prepare(input, settings, probe, stats);
    if (frozen) m.updateGains(settings);
    if (!stats.reason.empty()) {
        m.black();
        return stats;
    }
    const ScanFeatures features = m.requiredFeatures(m.planned);
    const Passes& passes = m.passesFor(frozen ? m.scanned_features : features);
    m.bindAll();
    m.commands.submitAndWait([&](const vk::raii::CommandBuffer& to) {
        if (!frozen) m.patient.recordUploads(to);
        m.record(to, passes, !frozen);
    });
    if (frozen) {
        stats.frozen_pictures = 1;
    } else {
        m.scanned_features = features;
        m.has_scan = true;
        m.count(features, stats);
    }
    ++m.revision;
    return stats;
}

void Ultrasound::setFlow(const patient::VesselFlow* flow) {
    Impl& m = *impl_;
    m.has_flow = flow && !flow->velocity.empty();
    if (!m.has_flow) return;
    m.flow_grid = flow->grid;
    m.flow_scale_m_per_s = flow->scale_m_per_s;
    m.flow = makeFilledVolume(m.gpu, vk::Format::eR16G16B16A16Sint, flow->grid.dims,
                              sizeof(flow->velocity[0]), flow->velocity.data());
    m.stale_bindings = true;
}

ScreenPicture Ultrasound::picture() const {
    const Impl& m = *impl_;
    return {m.width, m.height, static_cast<const std::uint8_t*>(m.pixels.mapped), m.revision};
}

std::span<const float> Ultrasound::envelope() const {
    const Impl& m = *impl_;
    if (!m.has_scan) return {};
    return {static_cast<const float*>(m.envelope.mapped),
            std::size_t(m.planned.lines) * std::size_t(m.planned.samples)};
}

}  // namespace stylet::render
