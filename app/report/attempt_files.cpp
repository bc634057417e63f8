#include "app/report/attempt_files.h"

#include <fmt/core.h>

#include <glm/geometric.hpp>

#include "app/records/samples.h"
#include "base/path.h"

namespace stylet::report {

namespace fs = std::filesystem;

namespace {

CourseRow makeCourseRow(const records::Sample& s, double dt_s) {
    CourseRow row;
    row.t_s = double(s.tick) * dt_s;
    row.in_body = s.phase != haptics::Phase::outside;
    row.depth_m = s.depth_m, row.force_n = s.force_n;
    row.sent_n = glm::length(s.sent_n);
    row.breath_v = s.breath_v;
    row.clearance_m = s.clearance_m;
    row.tip_m = s.tip_m, row.axis = s.axis;
    row.tool = s.tool, row.tissue = s.tissue;
    row.breath_held = s.breath_held;
    row.faults = s.faults;
    return row;
}

void loadCourse(LoadedAttempt& attempt, const fs::path& file) {
    if (!fs::exists(file)) {
        if (attempt.result()) attempt.warnings.push_back(file.string() + ": is gone");
        return;  // an attempt that was cut short may have no ticks
    }
    try {
        const records::Samples samples = records::parseSamples(records::readAll(file), file);
        attempt.course.reserve(samples.samples.size());
        for (const records::Sample& sample : samples.samples)
            attempt.course.push_back(makeCourseRow(sample, samples.header.dt_s));
        if (samples.torn_bytes > 0)
            attempt.warnings.push_back(fmt::format("{}: {} bytes behind the last whole frame are left out",
                                                   file.string(), samples.torn_bytes));
    } catch (const DataError& e) {
        attempt.warnings.emplace_back(e.what());
    }
}

}  // namespace

LoadedAttempt loadAttempt(const fs::path& folder) {
    records::Record record = records::loadAttemptHead(folder);
    LoadedAttempt attempt;
    attempt.stored = records::makeStoredAttempt(record, folder);
    attempt.record = std::move(record.info);
    attempt.needle = record.header.settings.tools.needle;
    attempt.needle_title = record.header.instruments.needle.title;
    attempt.input_only = haptics::isInputOnly(record.header.settings.profile);
    if (attempt.stored.id.empty())
        attempt.stored.id = withoutSlash(fs::weakly_canonical(folder)).filename().string();
    loadCourse(attempt, folder / "record" / "samples.bin");
    return attempt;
}

}  // namespace stylet::report
