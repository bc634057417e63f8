#include "tests/render/ultrasound/sound_phantoms.h"

#include <algorithm>
#include <cmath>

#include "tests/render/pictures.h"
#include "tests/render/ultrasound/scan_reference.h"
#include "tests/support/phantom.h"

namespace stylet::test {

using namespace render;

namespace {

// The label of each row of the table has its own structure: the row's number, not a name.
patient::Structure numbered(std::size_t row) {
    return patient::Structure(row);
}

}  // namespace

AcousticTable soundTable() {
    AcousticTable table = loadAcoustics(assetsFolder() / "ultrasound" / "tissues.toml");
    table.rules.clear();
    for (std::size_t i = 0; i < table.acoustics.size(); ++i) {
        AcousticRule& rule = table.rules.emplace_back();
        rule.structure = numbered(i), rule.acoustic = int(i);
    }
    for (Acoustic& a : table.acoustics)
        a.hu_span = 0.0;
    return table;
}

AcousticTable mirrorTable() {
    AcousticTable table = soundTable();
    table.roughness = 0.0;
    for (Acoustic& a : table.acoustics) {
        a.scatter_db = -200.0;
        a.attenuation_db_per_m_mhz = 0.0;
        a.wall_db.reset();
    }
    return table;
}

patient::Package soundBlock(const Vec3& half_m, double depth_m, double spacing_m,
                            const std::function<std::string(const Vec3&)>& tissueAt) {
    const double front_m = 0.005;
    patient::Package package;
    package.name = "sound phantom";
    package.tissues = tissueDefaults().tissues;
    package.thresholds = tissueDefaults().thresholds;
    Grid grid;
    grid.spacing_m = Vec3(spacing_m);
    grid.dims = Index3(glm::round(Vec3(2.0 * half_m.x, 2.0 * half_m.y, depth_m + front_m) / spacing_m));
    grid.origin_m = Vec3(-half_m.x, -half_m.y, -front_m) + 0.5 * grid.spacing_m;
    const AcousticTable table = soundTable();
    for (std::size_t i = 0; i < table.acoustics.size(); ++i) {
        patient::Label label;
        label.id = std::uint8_t(i + 1);
        label.name = table.acoustics[i].name;
        label.structure = numbered(i);
        package.label_table.push_back(label);
    }
    package.ct = CtVolume(grid, 40);
    package.labels = LabelVolume(grid);
    forEachVoxel(grid, [&](const Index3& i) {
        const std::string name = grid.centre(i).z < 0.0 ? "air" : tissueAt(grid.centre(i));
        const auto found = std::find_if(package.label_table.begin(), package.label_table.end(),
                                        [&](const patient::Label& l) { return l.name == name; });
        package.labels[i] = found->id;
    });
    return package;
}

patient::Package soundLayers(const std::vector<std::pair<std::string, double>>& layers_m, double depth_m,
                             double spacing_m) {
    return soundBlock(Vec3(0.030, 0.012, 0.0), depth_m, spacing_m, [&](const Vec3& p) {
        double end = 0.0;
        for (const auto& [name, thick] : layers_m)
            if (p.z < (end += thick)) return name;
        return layers_m.back().first;
    });
}

std::string scanMethodName(ScanMethod by) {
    return by == ScanMethod::reference ? "reference" : by == ScanMethod::serial ? "serial" : "prefix_sums";
}

double Scan::rms(double from_share, double to_share, double from_m, double to_m) const {
    double squares = 0.0, count = 0.0;
    for (int l = int(from_share * lines); l < int(to_share * lines); ++l)
        for (int j = int(from_m / bin_m); j < std::min(int(to_m / bin_m), bins); ++j) {
            squares += at(l, j) * at(l, j);
            ++count;
        }
    return std::sqrt(squares / count);
}

Scan scan(ScanMethod by, const patient::Package& package, const AcousticTable& table,
          const UltrasoundInput& input, UltrasoundSettings settings, const Transducer& probe) {
    const patient::Patient patient(package);
    settings.noise_db = -400.0;
    if (by == ScanMethod::reference) {
        const ReferenceScan s = referenceScan(
            encode(patient, table), table, [](const Vec3& p) { return p; }, input, settings, probe);
        return {s.lines, s.bins, s.bin_m, s.envelope};
    }
    const Gpu gpu({.validation = true});
    DeformedPatient still(gpu, patient);
    Ultrasound machine(gpu, still, table);
    settings.path = by == ScanMethod::serial ? ScanPath::serial : ScanPath::prefix_sums;
    machine.image(input, settings, probe);
    const auto e = machine.envelope();
    if (gpu.validationMessages() > 0) throw std::runtime_error("validation messages");
    return {settings.lines, settings.samples, makeScanPlan(probe, settings).bin_m, {e.begin(), e.end()}};
}

UltrasoundInput probeAt(double z_m) {
    UltrasoundInput input;
    input.patient_from_probe = Pose{{1, 0, 0, 0}, Vec3(0.0, 0.0, z_m)};
    return input;
}

Transducer flatProbe() {
    Transducer probe;
    probe.shape = TransducerShape::linear;
    probe.width_m = 0.040;
    probe.depth_m = 0.060;
    probe.focus_m = 0.030;
    return probe;
}

}  // namespace stylet::test
