#include "tests/bench/picture_case.h"
#include "tests/bench/reference_patient.h"

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <stdexcept>

#include <fmt/core.h>

namespace stylet::bench {
namespace {

constexpr int kRepeats = 3;

}  // namespace

PictureCase::PictureCase() : package(referencePatient(0.00115)) {
    const Grid& grid = package.ct.grid;
    at_m = grid.origin_m + 0.5 * grid.spacing_m * Vec3(grid.dims - 1);
    eye_m = at_m + 0.70 * glm::normalize(Vec3(0.35, 0.35, 0.25));
}

render::LookStyle pictureLook(const std::string& name) {
    return render::loadLook(std::filesystem::path(STYLET_BENCH_LOOKS) / (name + ".toml"));
}

HuTable huTable(const render::LookStyle& look, const patient::Patient& patient) {
    HuTable table;
    for (const glm::vec4& stored : render::makePalette(look, patient).hu) {
        const double a = double(stored.a);
        table.extinction_per_m.push_back(a * a * look.full_extinction_per_m);
        const glm::vec3 root = glm::vec3(stored) / std::max(stored.a, 1e-4f);
        table.colour_linear.push_back(root * root);
    }
    return table;
}

double psnr(const Pixels& a, const Pixels& b) {
    if (a.rgba.size() != b.rgba.size()) throw std::runtime_error("pictures of different sizes");
    double squares = 1e-6;
    for (std::size_t i = 0; i < a.rgba.size(); ++i)
        if (i % 4 != 3) squares += std::pow(double(a.rgba[i]) - double(b.rgba[i]), 2.0);
    return 10.0 * std::log10(255.0 * 255.0 * 0.75 * double(a.rgba.size()) / squares);
}

void writePpm(const std::string& path, const Pixels& p) {
    std::ofstream file(path, std::ios::binary);
    file << "P6\n" << p.width << ' ' << p.height << "\n255\n";
    for (std::size_t i = 0; i < p.rgba.size(); ++i)
        if (i % 4 != 3) file.put(char(p.rgba[i]));
}

void matchedRows(const std::string& name, const std::string& note, const std::vector<double>& steps,
                 const Draw& draw, std::vector<Row>& rows, double share) {
    constexpr int kSmall = 512, kLarge = 1024;
    const auto measure = [&](int size, double step, const Pixels* truth) {
        const Pixels picture = draw(size, step);  // warm-up, not timed
        const double distance_db = truth ? psnr(picture, *truth) : 0.0;
        std::vector<double> times, work;
        for (int i = 0; i < kRepeats; ++i) {
            const auto begun = std::chrono::steady_clock::now();
            const std::clock_t before = std::clock();
            draw(size, step);
            times.push_back(elapsed_ms(begun));
            work.push_back(1000.0 * double(std::clock() - before) / CLOCKS_PER_SEC);
        }
        // Processor time does not depend on other processes.
        const std::string spent = fmt::format(", {:.0f} ms of processor time", share * median(work));
        rows.push_back({name, "step, voxels", step, share * median(times), distance_db, "dB PSNR",
                        truth ? "its own at 0.1 voxel" : "none, the step that 512 x 512 needs",
                        fmt::format("{} x {}", size, size) + note + spent});
        return distance_db;
    };
    const Pixels truth = draw(kSmall, 0.0);
    if (const char* folder = std::getenv("STYLET_BENCH_PICTURES"))
        writePpm(std::string(folder) + "/" + name + ".ppm", truth);
    double matched = steps.back();
    for (const double step : steps)
        if (measure(kSmall, step, &truth) >= kMatched_db) {
            matched = step;
            rows.back().note += ", matched";
            break;
        }
    if (!isLongRun()) {
        measure(kLarge, matched, nullptr);
        return;
    }
    const Pixels large = draw(kLarge, 0.0);
    measure(kLarge, matched, &large);
}

}  // namespace stylet::bench
