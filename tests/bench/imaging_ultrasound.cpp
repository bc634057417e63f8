// Benchmark of the ultrasound of the breathing reference patient, 160 mm deep. It reports the time of a
// picture and its difference from a finer one. Pulse reach and breathing look-ups are compared pixel by
// pixel. A change of lines, samples or planes changes the speckle itself. Those pictures are therefore
// compared after a mean over 8 x 8 pixels (3.5 mm), which preserves the anatomy. The note has the figure
// without the mean.
#include <cstdlib>
#include <stdexcept>

#include <fmt/core.h>

#include "patient/contrast/vessel_flow.h"
#include "render/volume/deformed_patient.h"
#include "tests/bench/gpu.h"
#include "tests/bench/picture_case.h"
#include "tests/bench/reference_patient.h"
#include "tests/render/pictures.h"
#include "tests/render/ultrasound/scan_reference.h"

namespace stylet::bench {
namespace {

constexpr int kRepeats = 7, kBlock = 8;

// Pose of a probe pressed onto the skin and aimed along -`out` at the centroid of the label's voxels. `up`
// points to the left of the picture, after projection into the image plane.
Pose probeToward(const patient::Patient& patient, const char* label, const Vec3& out, const Vec3& up,
                 double press_m = 0.010) {
    const patient::Package& package = patient.package();
    const Grid& grid = package.ct.grid;
    Vec3 sum(0.0);
    double count = 0.0;
    for (std::size_t i = 0; i < package.labels.voxels.size(); ++i) {
        const patient::Label* l = patient.label(package.labels.voxels[i]);
        if (!l || l->name != label) continue;
        sum += grid.centre(grid.voxelAt(i));
        ++count;
    }
    const Vec3 target = sum / count, z = -glm::normalize(out);
    Vec3 face = target;
    for (double way = 0.0; way < 0.3; way += 0.0005)
        if (package.ct.nearestOr(target - way * z, -1000) > -300) face = target - way * z;
    const Vec3 x = -glm::normalize(up - z * glm::dot(up, z));
    return {glm::quat_cast(glm::dmat3(x, glm::cross(z, x), z)), face + press_m * z};
}

struct UltrasoundFixture {
    patient::Package package = referencePatient(0.0015);
    patient::Patient patient{package};
    render::Gpu gpu{render::GpuSettings{}};
    render::DeformedPatient deformed{gpu, patient};
    render::AcousticTable table = render::loadAcoustics(test::assetsFolder() / "ultrasound" / "tissues.toml");
    render::Transducer probe = render::loadTransducer(test::assetsFolder() / "ultrasound" / "convex.toml");
    render::Ultrasound machine{gpu, deformed, table};
    render::UltrasoundInput input;

    UltrasoundFixture() {
        input.patient_from_probe = probeToward(patient, "liver", {0.8, 0.75, -0.35}, {0, 0, 1});
        breathe(0.5);
    }
    void breathe(double v) {
        patient::Surrogate now = package.motion.reference;
        now.v += v;
        deformed.breathe(now, deformed.atRest(now));
    }
    Pixels picture(const render::UltrasoundSettings& settings, double* median_ms = nullptr) {
        machine.image(input, settings, probe);  // renders the picture and warms up
        if (median_ms) *median_ms = medianTime_ms(kRepeats, [&] { machine.image(input, settings, probe); });
        const render::ScreenPicture shown = machine.picture();
        return {shown.width, shown.height, {shown.rgba, shown.rgba + 4 * shown.width * shown.height}};
    }
};

// Downsamples by the mean over kBlock x kBlock pixels.
Pixels blurred(const Pixels& fine) {
    Pixels coarse{fine.width / kBlock, fine.height / kBlock, {}};
    for (int y = 0; y < coarse.height; ++y)
        for (int x = 0; x < coarse.width; ++x)
            for (int c = 0; c < 4; ++c) {
                int sum = 0;
                for (int k = 0; k < kBlock * kBlock; ++k)
                    sum += fine.rgba[std::size_t(
                        4 * ((kBlock * y + k / kBlock) * fine.width + kBlock * x + k % kBlock) + c)];
                coarse.rgba.push_back(std::uint8_t((sum + kBlock * kBlock / 2) / (kBlock * kBlock)));
            }
    return coarse;
}

render::UltrasoundSettings quiet() {
    render::UltrasoundSettings settings;
    settings.noise_db = -400.0;  // off: noise would differ with the sampling
    return settings;
}

struct Knob {
    const char* name;
    std::vector<double> values;
    double fallback;  // the default
    bool same_grain;
    void (*set)(render::UltrasoundSettings&, double);
    double reference;
};

void knobRows(UltrasoundFixture& fixture, const Knob& knob, std::vector<Row>& rows) {
    render::UltrasoundSettings settings = quiet();
    knob.set(settings, knob.reference);
    const Pixels truth = fixture.picture(settings);
    for (const double value : knob.values) {
        knob.set(settings, value);
        double took_ms = 0.0;
        const Pixels picture = fixture.picture(settings, &took_ms);
        const double bare = psnr(picture, truth), calm = psnr(blurred(picture), blurred(truth));
        const std::string note =
            fmt::format("{}{:.1f} dB pixel by pixel", value == knob.fallback ? "default, " : "", bare);
        const std::string reference = fmt::format("{} = {:g}", knob.name, knob.reference);
        rows.push_back({"imaging.ultrasound", knob.name, value, took_ms, knob.same_grain ? bare : calm,
                        knob.same_grain ? "dB PSNR" : "dB PSNR of 8 x 8 means", reference, note});
    }
}

// Compares the GPU picture with a naive double-precision reference, for both scan paths. The probe face is
// narrowed so that all of it touches the skin: the reference does not model air.
void referenceRows(UltrasoundFixture& fixture, std::vector<Row>& rows) {
    render::UltrasoundSettings settings = quiet();
    settings.place_samples = 1;
    settings.gel_m = 0.0;
    fixture.probe.half_angle_rad = 0.3;
    const auto undeform = [&](const Vec3& p) { return referenceFromTables(fixture.deformed.tables(), p); };
    const auto truth = test::referencePicture(
        test::referenceScan(test::encode(fixture.patient, fixture.table), fixture.table, undeform,
                            fixture.input, settings, fixture.probe),
        settings, fixture.probe);
    for (const auto path : {render::ScanPath::serial, render::ScanPath::prefix_sums}) {
        settings.path = path;
        double took_ms = 0.0;
        Pixels picture = fixture.picture(settings, &took_ms);
        Pixels exact = picture;
        for (int i = 0; i < exact.width * exact.height; ++i)
            if (i % exact.width < exact.width - 16)
                for (int c = 0; c < 3; ++c)
                    exact.rgba[std::size_t(4 * i + c)] = std::uint8_t(255.0 * truth[std::size_t(i)] + 0.5);
        if (fixture.machine.image(fixture.input, settings, fixture.probe).contact < 1.0)
            throw std::runtime_error("imaging.ultrasound: the reference's probe does not touch");
        rows.push_back({"imaging.ultrasound", "path", double(path), took_ms, psnr(picture, exact), "dB PSNR",
                        "double precision, naively",
                        path == render::ScanPath::serial ? "serial lines" : "prefix sums"});
    }
}

void skipRows(UltrasoundFixture& fixture, std::vector<Row>& rows) {
    const auto add = [&](const char* knob, bool on, const render::UltrasoundSettings& settings,
                         const Pixels& truth, const std::string& note) {
        double took_ms = 0.0;
        const Pixels picture = fixture.picture(settings, &took_ms);
        rows.push_back({"imaging.ultrasound", knob, on ? 1.0 : 0.0, took_ms, psnr(picture, truth), "dB PSNR",
                        "this one off", note});
    };
    fixture.deformed.breathe(fixture.package.motion.reference, false);
    const Pixels truth = fixture.picture(quiet());
    add("skip still patient", false, quiet(), truth, "patient at rest");
    fixture.breathe(0.0);
    add("skip still patient", true, quiet(), truth, "patient at rest, default");
    fixture.breathe(0.5);
    render::UltrasoundSettings frozen = quiet();
    const Pixels live = fixture.picture(frozen);
    frozen.freeze = true;
    add("freeze", true, frozen, live, "gains and picture only");
}

// Depots of injected fluid, 8 mm apart around the middle of the picture.
void depotRows(UltrasoundFixture& fixture, std::vector<Row>& rows) {
    for (const int count : {0, 4, render::gpu::kMaxDepots}) {
        fixture.input.depots.clear();
        for (int i = 0; i < count; ++i)
            fixture.input.depots.push_back({*fixture.input.patient_from_probe *
                                                Vec3(0.008 * (i % 8 - 3.5), 0.0, 0.060 + 0.008 * (i / 8)),
                                            0.005});
        render::UltrasoundSettings settings = quiet();
        settings.place_samples = 1;
        const Pixels truth = fixture.picture(settings);
        double took_ms = 0.0;
        const Pixels picture = fixture.picture(quiet(), &took_ms);
        rows.push_back({"imaging.ultrasound", "depots", double(count), took_ms, psnr(picture, truth),
                        "dB PSNR", "place_samples = 1", "of local anaesthetic"});
    }
    fixture.input.depots.clear();
}

// Writes pictures for a sonographer to inspect, if STYLET_BENCH_PICTURES names a folder.
void drawPictures(UltrasoundFixture& fixture) {
    const char* folder = std::getenv("STYLET_BENCH_PICTURES");
    if (!folder) return;
    const Pose before = *fixture.input.patient_from_probe;
    fixture.breathe(0.0);
    const auto draw = [&](const char* name, const render::UltrasoundSettings& settings) {
        writePpm(std::string(folder) + "/ultrasound_" + name + ".ppm", fixture.picture(settings));
    };
    render::UltrasoundSettings settings;
    draw("subcostal", settings);
    const Pose across{glm::angleAxis(-1.15, Vec3(0, 1, 0)), Vec3(-0.012, 0.0, 0.052)};
    fixture.input.patient_from_needle = *fixture.input.patient_from_probe * across;
    draw("needle", settings);
    fixture.input.patient_from_needle->position_m +=
        fixture.input.patient_from_probe->direction({0, 0.008, 0});
    draw("needle_out_of_plane", settings);
    fixture.input.patient_from_needle.reset();
    fixture.input.patient_from_probe = probeToward(fixture.patient, "liver", {1, 0.2, 0}, {0, 1, 0});
    draw("intercostal", settings);
    fixture.input.patient_from_probe =
        probeToward(fixture.patient, "portal vein", {0.55, 0.8, -0.2}, {0, 0, 1});
    draw("portal", settings);
    const patient::VesselFlow flow = makeVesselFlow(fixture.patient);
    fixture.machine.setFlow(&flow);
    settings.doppler = render::DopplerBox{.from_share = 0.2, .to_share = 0.8, .from_m = 0.03, .to_m = 0.12};
    draw("doppler", settings);
    fixture.machine.setFlow(nullptr);
    fixture.input.patient_from_probe = before;
    fixture.breathe(0.5);
}

void run(std::vector<Row>& rows) {
    if (!hasGpu("imaging.ultrasound")) return;
    using Settings = render::UltrasoundSettings;
    UltrasoundFixture fixture;
    const Settings defaults;
    const Knob knobs[] = {
        {"lines",
         {64, 128, 192, 256, 384},
         double(defaults.lines),
         false,
         [](Settings& s, double v) { s.lines = int(v); },
         512},
        {"samples",
         {128, 256, 384, 512, 1024},
         double(defaults.samples),
         false,
         [](Settings& s, double v) { s.samples = int(v); },
         2048},
        {"planes",
         {1, 3, 5, 9},
         double(defaults.planes),
         false,
         [](Settings& s, double v) { s.planes = int(v); },
         17},
        {"reach_sigma",
         {1.0, 1.5, 2.0, 2.5, 3.0},
         defaults.reach_sigma,
         true,
         [](Settings& s, double v) { s.reach_sigma = v; },
         4.0},
        {"place_samples",
         {1, 4, 8, 16, 32, 64},
         double(defaults.place_samples),
         true,
         [](Settings& s, double v) { s.place_samples = int(v); },
         1},
    };
    for (const Knob& knob : knobs)
        knobRows(fixture, knob, rows);
    skipRows(fixture, rows);
    depotRows(fixture, rows);
    drawPictures(fixture);
    if (isLongRun()) referenceRows(fixture, rows);
}

const Registration registration("imaging.ultrasound", run);

}  // namespace
}  // namespace stylet::bench
