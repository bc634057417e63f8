#include "render/ultrasound/contact.h"

#include <algorithm>

#include "render/ultrasound/acoustic_volume.h"

namespace stylet::render {
namespace {

constexpr double kStep_m = 0.0005;
constexpr double kFading = 0.5;  // coupling fades beyond this share of the thickest gel
constexpr double kBoneSpeed_m_per_s = 3000.0;

Vec3 referencePosition(const DeformedPatient& patient, const Vec3& p) {
    const Vec3 q = patient.tool() ? p - displacementAt(*patient.tool(), p) : p;
    return patient.still() ? q : referenceFromTables(patient.tables(), q);
}

}  // namespace

void findContact(const Transducer& probe, const UltrasoundSettings& settings, const Pose& patient_from_probe,
                 const AcousticPatient& acoustic, Contact& contact) {
    const DeformedPatient& patient = acoustic.patient;
    const AcousticTable& table = acoustic.table;
    const patient::Patient& at_rest = patient.patient();
    const auto tissueAt = [&](const Vec3& p) {
        return acousticAt(at_rest, table, acoustic.label_rows,
                          at_rest.grid().nearest(referencePosition(patient, p)));
    };
    contact.lines.resize(std::size_t(settings.lines));
    int touching = 0;
    for (int l = 0; l < settings.lines; ++l) {
        const ScanLine line = scanLine(probe, 2.0 * l / (settings.lines - 1) - 1.0);
        LineContact& c = contact.lines[std::size_t(l)];
        c = {};
        double gap = 0.0;
        while (gap <= settings.gel_m &&
               tissueAt(patient_from_probe * (line.origin_m + gap * line.direction)) == table.air)
            gap += kStep_m;
        if (gap > settings.gel_m) continue;
        const double thick = gap / std::max(settings.gel_m, kStep_m);
        c.gel_m = gap;
        c.coupling = std::clamp((1.0 - thick) / (1.0 - kFading), 0.05, 1.0);
        ++touching;
    }
    contact.share = double(touching) / settings.lines;
    const int middle = tissueAt(patient_from_probe.position_m);
    contact.in_bone = table.acoustics[std::size_t(middle)].speed_m_per_s > kBoneSpeed_m_per_s;
}

}  // namespace stylet::render
