// stylet-soak [--ticks N] [--seed N] [--spacing-mm MM] [--pictures] [--centre] [--breath FILE.csv]
// [--out FILE.json]: see soak.h. Exits with 1 if a resource grew, the process became slower,
// or a result differed.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <optional>

#include "app/options.h"
#include "tests/bench/soak/soak.h"
#include "tests/support/postgres.h"
#include "tests/support/temp_folder.h"

int main(int argc, char** argv) {
    using namespace stylet;
    CLI::App app("attempts for hours of virtual time in one process: nothing may grow", "stylet-soak");
    double ticks = 1e8, spacing_mm = 3.0;
    soak::Settings settings;
    std::string out;
    bool centre = false;
    app.add_option("--ticks", ticks, "at least so many")->check(inRange(1.0, 1e12));
    app.add_option("--seed", settings.seed, "of the patient and the hands");
    app.add_option("--spacing-mm", spacing_mm, "of the reference patient")->check(inRange(1.0, 10.0));
    app.add_flag("--pictures", settings.pictures, "the room in the mock runtime's headset too: needs Vulkan");
    app.add_flag("--centre", centre, "send to a PostgreSQL of its own too: needs the server's programs");
    app.add_option("--breath", settings.breath, "a marker's track, breathed for longer than it is");
    app.add_option("--out", out, "the figures, as JSON");
    CLI11_PARSE(app, argc, argv);
    settings.ticks = std::uint64_t(ticks);
    settings.spacing_m = 1e-3 * spacing_mm;
    settings.log = [](const std::string& line) { std::printf("%s\n", line.c_str()), std::fflush(stdout); };
    try {
        const test::TempFolder folder;
        settings.folder = folder.path();
        std::optional<test::Postgres> postgres;
        if (centre) settings.centre = postgres.emplace().url();
        const soak::Result result = soak::soak(settings);
        std::fputs(soak::formatReport(result).c_str(), stdout);
        if (!out.empty()) soak::writeJson(result, settings, out);
        const std::vector<std::string> bad = soak::findFailures(result, settings);
        for (const std::string& line : bad)
            std::printf("  FAILED: %s\n", line.c_str());
        return bad.empty() ? 0 : 1;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "stylet-soak: %s\n", e.what());
        return 2;
    }
}
