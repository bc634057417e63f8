#include "render/deform.h"

#include <algorithm>

namespace stylet::render {
namespace {

constexpr int kEntries = 256;

glm::vec4 ellipseAt(const std::vector<patient::CavityKnot>& knots, double z_m) {
    const auto above = std::find_if(knots.begin(), knots.end(), [&](const auto& k) { return k.z_m > z_m; });
    const auto row = [](const patient::CavityKnot& k) { return glm::dvec4(k.x_m, k.y_m, k.rx_m, k.ry_m); };
    if (above == knots.begin()) return glm::vec4(row(knots.front()));
    if (above == knots.end()) return glm::vec4(row(knots.back()));
    const auto below = above - 1;
    return glm::vec4(glm::mix(row(*below), row(*above), (z_m - below->z_m) / (above->z_m - below->z_m)));
}

patient::BreathingTable stillTable(const patient::BreathingModel& model) {
    patient::BreathingTable table;
    table.z_begin_m = model.cavity.front().z_m;
    table.dz_m = (model.cavity.back().z_m - model.cavity.front().z_m) / (kEntries - 1);
    for (int i = 0; i < kEntries; ++i)
        table.inside_reference_z_m.push_back(float(table.z_begin_m + i * table.dz_m));
    table.outside_reference_z_m = table.inside_reference_z_m;
    return table;
}

}  // namespace

BreathRows breathRows(const patient::BreathingModel& model, const patient::Surrogate& now) {
    BreathRows breath;
    breath.fade_rho = model.fade_rho;
    if (model.cavity.size() < 2) {  // does not breathe: no z lies within these rows
        breath.z_begin_m = 1e6;
        breath.rows.assign(2, gpu::BreathRow{glm::vec4(0, 0, 1, 1), glm::vec4(0)});
        return breath;
    }
    patient::BreathingTable table = patient::breathingTable(model, now, kEntries);
    if (table.inside_reference_z_m.empty()) table = stillTable(model);
    breath.z_begin_m = table.z_begin_m;
    breath.dz_m = table.dz_m;
    for (std::size_t i = 0; i < table.inside_reference_z_m.size(); ++i) {
        const double z = table.z_begin_m + double(i) * table.dz_m;
        const bool moves = z >= model.cavity.front().z_m && z <= model.cavity.back().z_m;
        const float inside = moves ? table.inside_reference_z_m[i] : float(z);
        const float outside = moves ? table.outside_reference_z_m[i] : float(z);
        breath.rows.push_back({ellipseAt(model.cavity, z), glm::vec4(inside, outside, 0, 0)});
    }
    return breath;
}

}  // namespace stylet::render
