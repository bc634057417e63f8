// Displacement of tissue by a tool, for the picture: its time per frame and its error against the converged
// solution, for four tool contacts at the reference patient's flank.
#include <cmath>
#include <cstdio>
#include <random>

#include <fmt/core.h>

#include "patient/displacement/tool_displacement.h"
#include "patient/patient.h"
#include "tests/bench/bench.h"
#include "tests/bench/reference_patient.h"

namespace stylet::bench {
namespace {

using namespace patient;

constexpr double kFrame_s = 1.0 / 90.0;
constexpr int kFrames = 18;  // frames of one press
constexpr double kNear_m = 0.030;
constexpr int kPoints = 20000;
const Surrogate kNow{0.4, 0.3};

struct Case {
    const char* name;
    ToolContact contact;
    std::vector<Vec3> points_m;     // points in the body near the contact
    std::vector<Vec3> reference_m;  // converged displacement of each point
};

struct Flank {
    Package package = referencePatient(0.0015);
    Patient patient{package};
    std::vector<Case> cases;
};

bool isBone(const Patient& patient, const Vec3& p) {
    const Package& package = patient.package();
    const Label* label =
        patient.label(package.labels.nearestOr(referenceFromDeformed(package.motion, kNow, p), 0));
    return label && isSkeleton(label->tissue);
}

Vec3 toSkin(const Patient& patient, Vec3 from_m) {
    const Package& p = patient.package();
    while (p.labels.nearestOr(referenceFromDeformed(p.motion, kNow, from_m), 0) == 0)
        from_m.x -= 0.0005;
    return from_m;
}

// Finds the skin on the patient's right at the height of the liver's centre.
Vec3 findFlankSkin(const Patient& patient) {
    const Package& p = patient.package();
    const Grid& g = p.labels.grid;
    Vec3 sum(0.0);
    double count = 0.0;
    forEachVoxel(g, [&](const Index3& i) {
        const Label* label = patient.label(p.labels[i]);
        if (label && label->tissue == Tissue::liver) sum += g.centre(i), count += 1.0;
    });
    const Vec3 middle_m = sum / std::max(count, 1.0);
    return toSkin(patient, {g.centre(g.dims - 1).x, middle_m.y, middle_m.z});
}

// Finds the nearest skin point headward of `skin_m` with bone 8 to 24 mm under it. Returns `skin_m` if
// there is none within 60 mm.
Vec3 skinOverRib(const Patient& patient, Vec3 skin_m) {
    const double right_m = patient.grid().centre(patient.grid().dims - 1).x;
    for (int step = 0; step < 60; ++step) {
        const Vec3 at_m = toSkin(patient, {right_m, skin_m.y, skin_m.z + 0.001 * step});
        for (double under_m = 0.008; under_m < 0.024; under_m += 0.001)
            if (isBone(patient, at_m - Vec3(under_m, 0.0, 0.0))) return at_m;
    }
    std::fprintf(stderr, "patient.tool_displacement: no rib under the flank\n");
    return skin_m;
}

void converge(Case& c, const Patient& patient) {
    ToolDisplacement fine(patient, {.nodes = 129, .spacing_m = 0.00075, .cycles = 10, .sweeps = 2});
    fine.update({&c.contact, 1}, kNow, kFrame_s);
    std::mt19937 random(3);
    const auto share = [&] { return double(random()) / 4294967296.0; };
    const Vec3 low = glm::min(c.contact.begin_m, c.contact.end_m) - kNear_m;
    const Vec3 extent = glm::max(c.contact.begin_m, c.contact.end_m) + kNear_m - low;
    while (int(c.points_m.size()) < kPoints) {
        const Vec3 p = low + extent * Vec3(share(), share(), share());
        const Vec3 moved = displacementAt(fine.table(), p);
        const Vec3 reference = referenceFromDeformed(patient.package().motion, kNow, p - moved);
        if (patient.package().labels.nearestOr(reference, 0) == 0) continue;
        c.points_m.push_back(p), c.reference_m.push_back(moved);
    }
}

void addCases(Flank& flank) {
    const Vec3 skin_m = findFlankSkin(flank.patient), inward = glm::normalize(Vec3(-1.0, -0.2, 0.3));
    const auto add = [&](const char* name, const Vec3& begin_m, const Vec3& end_m, double moved_m,
                         double radius_m) {
        flank.cases.push_back(
            {name, {0, begin_m, end_m, moved_m * inward, moved_m * inward, radius_m}, {}, {}});
    };
    add("needle, 2.5 mm", skin_m, skin_m, 0.0025, 0.004);
    add("finger, 6 mm", skin_m, skin_m, 0.006, 0.006);
    add("shaft drawn out, 0.9 mm", skin_m, skin_m + 0.030 * inward, -0.0009, 0.004);
    const Vec3 over_rib_m = skinOverRib(flank.patient, skin_m);
    add("finger over a rib, 4 mm", over_rib_m, over_rib_m, 0.004, 0.006);
    for (Case& c : flank.cases)
        converge(c, flank.patient);
}

// Each figure is the maximum over all cases. `worst` names the case with the largest p99 error.
struct Measured {
    double mean_mm = 0.0, p99_mm = 0.0, max_mm = 0.0, time_ms = 0.0;
    const char* worst = "";

    void add(const Case& c, const DisplacementTable& table, double ms) {
        std::vector<double> errors_mm;
        for (std::size_t i = 0; i < c.points_m.size(); ++i)
            errors_mm.push_back(1e3 * glm::length(displacementAt(table, c.points_m[i]) - c.reference_m[i]));
        const double own_mm = quantile(errors_mm, 0.99);
        if (own_mm > p99_mm) worst = c.name;
        p99_mm = std::max(p99_mm, own_mm);
        mean_mm = std::max(mean_mm, mean(errors_mm));
        max_mm = std::max(max_mm, quantile(errors_mm, 1.0));
        time_ms = std::max(time_ms, ms);
    }
};

void report(std::vector<Row>& rows, const std::string& knob, double value, const Measured& m,
            const std::string& of) {
    const std::string note = fmt::format("{}; mean {:.3f} p99 {:.3f} max {:.3f} mm, worst: {}", of, m.mean_mm,
                                         m.p99_mm, m.max_mm, m.worst);
    rows.push_back({"patient.tool_displacement", knob, value, m.time_ms, m.p99_mm, "mm p99",
                    "nodes of 0.75 mm, 40 cycles", note});
}

// Presses at constant speed. The table of the last frame is compared with the converged solution.
Measured press(const Flank& flank, const ToolDisplacementSettings& settings) {
    Measured m;
    for (const Case& c : flank.cases) {
        ToolDisplacement tool(flank.patient, settings);
        std::vector<double> times_ms;
        for (int frame = 1; frame <= kFrames; ++frame) {
            ToolContact contact = c.contact;
            contact.begin_moved_m *= double(frame) / kFrames, contact.end_moved_m *= double(frame) / kFrames;
            const auto began = std::chrono::steady_clock::now();
            tool.update({&contact, 1}, kNow, kFrame_s);
            times_ms.push_back(elapsed_ms(began));
        }
        m.add(c, tool.table(), median(times_ms));
    }
    return m;
}

// Regularised Kelvinlets (de Goes and James 2017): a push on a ball of a uniform, nearly incompressible
// medium in closed form. A shaft is represented by `along` of them. The method ignores bone and the free skin
// surface.
Measured kelvinlets(const Flank& flank, int along) {
    constexpr double kPoisson = 0.45;
    constexpr double a = 1.0, b = a / (4.0 * (1.0 - kPoisson));
    Measured m;
    for (const Case& c : flank.cases) {
        ToolDisplacement placed(flank.patient);
        placed.update({&c.contact, 1}, kNow, kFrame_s);
        DisplacementTable table = placed.table();
        const double radius_m = std::max(c.contact.radius_m, 1.5 * glm::length(c.contact.begin_moved_m));
        const int count = c.contact.begin_m == c.contact.end_m ? 1 : along;
        const auto at = [&](const Vec3& p) {
            Vec3 sum(0.0);
            for (int i = 0; i < count; ++i) {
                const double share = count > 1 ? double(i) / (count - 1) : 0.0;
                const Vec3 r =
                    p - glm::mix(c.contact.begin_m, c.contact.end_m, share) - c.contact.begin_moved_m;
                const double far_m = std::sqrt(glm::dot(r, r) + radius_m * radius_m);
                const Vec3 f = c.contact.begin_moved_m;
                sum += ((a - b) / far_m + 0.5 * a * radius_m * radius_m / (far_m * far_m * far_m)) * f +
                       b / (far_m * far_m * far_m) * glm::dot(r, f) * r;
            }
            return sum;
        };
        const auto began = std::chrono::steady_clock::now();
        const Vec3 middle_m = 0.5 * (c.contact.begin_m + c.contact.end_m) + c.contact.begin_moved_m;
        const double scale = glm::length(c.contact.begin_moved_m) / glm::length(at(middle_m));
        const Grid& g = table.grid;
        forEachVoxel(g, [&](const Index3& i) {
            table.moved_m[g.offset(i)] = glm::vec4(glm::vec3(scale * at(g.centre(i))), 0.0f);
        });
        m.add(c, table, elapsed_ms(began));
    }
    return m;
}

void run(std::vector<Row>& rows) {
    Flank flank;
    addCases(flank);
    const ToolDisplacementSettings usual;
    for (const auto& [nodes, mm] :
         {std::pair{17, 6.0}, {33, 4.0}, {33, 3.0}, {33, 2.5}, {33, 2.0}, {65, 1.5}}) {
        ToolDisplacementSettings s = usual;
        s.nodes = nodes, s.spacing_m = 1e-3 * mm;
        report(rows, "nodes [mm]", mm, press(flank, s), std::to_string(nodes) + " a side, one thread");
    }
    for (const int cycles : {1, 2, 4, 8}) {
        ToolDisplacementSettings s = usual;
        s.cycles = cycles;
        report(rows, "cycles a frame", cycles, press(flank, s), "one thread");
    }
    for (const int sweeps : {1, 2, 3}) {
        ToolDisplacementSettings s = usual;
        s.sweeps = sweeps;
        report(rows, "sweeps a cycle", sweeps, press(flank, s), "one thread");
    }
    report(rows, "Kelvinlets instead, along a shaft", 6, kelvinlets(flank, 6), "33 a side, one thread");
}
const Registration registration("patient.tool_displacement", run);

}  // namespace
}  // namespace stylet::bench
