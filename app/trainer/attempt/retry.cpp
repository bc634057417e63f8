#include "app/trainer/attempt/retry.h"

#include <fmt/core.h>
#include <bit>

#include "app/records/replay.h"
#include "base/text.h"

namespace stylet::trainer {

using records::Bookmark;

namespace {

namespace fs = std::filesystem;

fs::path findRecordFolder(const std::string& attempt, const fs::path& store) {
    if (attempt.empty()) throw DataError("@", "--from", "names no attempt");
    if (const fs::path folder = records::recordFolder(attempt); fs::exists(folder / "record.json"))
        return folder;
    const fs::path kept = store / "attempts" / fs::path(attempt).filename() / "record";
    if (!fs::path(attempt).has_parent_path() && fs::exists(kept / "record.json")) return kept;
    throw DataError(attempt, "--from", "is neither an attempt folder nor an attempt id in " + store.string());
}

std::string listOf(const std::vector<Bookmark>& marks) {
    std::string list;
    for (std::size_t i = 0; i < marks.size(); ++i)
        list += fmt::format("{}{}{}", i > 0 ? ", " : "", i + 1,
                            marks[i].text.empty() ? "" : " (" + marks[i].text + ")");
    return list;
}

// Index of the chosen bookmark, from 0.
std::size_t chosen(const std::vector<Bookmark>& marks, const std::string& wanted, const fs::path& folder) {
    if (marks.empty())
        throw DataError(
            folder, "bookmarks",
            "the attempt has none: press F8 in the window or type \"bookmark\" during an attempt to set one");
    if (wanted.empty()) return marks.size() - 1;
    for (std::size_t i = 0; i < marks.size(); ++i)
        if (marks[i].text == wanted) return i;
    if (const auto number = parseNumber<std::size_t>(wanted);
        number && *number >= 1 && *number <= marks.size())
        return *number - 1;
    throw DataError(folder, "bookmark " + wanted, "not among: " + listOf(marks));
}

}  // namespace

training::Course recordedCourse(const records::RecordInfo& info) {
    if (const auto course = findEnum<training::Course>(training::kCourseNames, info.course)) return *course;
    throw DataError("record.json", "course", "\"" + info.course + "\" is neither puncture nor drainage");
}

std::shared_ptr<const training::PatientCase> recordedCase(const records::RecordInfo& info) {
    if (info.patient_case.empty()) return nullptr;
    return std::make_shared<const training::PatientCase>(
        training::parseCase(info.patient_case, "record.json: case"));
}

Retry openRetry(const std::string& from, const fs::path& store) {
    const std::size_t at = from.rfind('@');
    const bool whole = at == std::string::npos || fs::exists(from);
    Retry retry;
    retry.folder = findRecordFolder(whole ? from : from.substr(0, at), store);
    retry.record = records::loadRecord(retry.folder);
    const std::vector<Bookmark>& marks = retry.record.info.bookmarks;
    std::size_t i = chosen(marks, whole ? "" : from.substr(at + 1), retry.folder);
    // If the program was killed, the ticks of the last bookmarks may be missing. Use the last bookmark whose
    // ticks are complete.
    while (whole && i > 0 && marks[i].tick > retry.record.inputs.size())
        --i;
    retry.number = i + 1;
    retry.bookmark = marks[i];
    if (retry.bookmark.tick > retry.record.inputs.size())
        throw DataError(retry.folder, "bookmark " + std::to_string(retry.number),
                        "the record ends before it, at tick " + std::to_string(retry.record.inputs.size()));
    retry.record.inputs.resize(retry.bookmark.tick);
    std::erase_if(retry.record.checkpoints,
                  [&](const records::Checkpoint& c) { return c.ticks > retry.bookmark.tick; });
    retry.record.info.end.reset();
    return retry;
}

void checkRetry(Retry& retry, const patient::Patient& patient, const MakeTouch& make_touch) {
    retry.left.tool = retry.record.header.settings.tools.first;
    const records::ReplayResult result = records::replay(
        patient, retry.record,
        [&](const haptics::TickInput&, const haptics::TickOutput& now, const haptics::NeedleEvents&) {
            retry.left = now;
        },
        make_touch);
    if (result.first_mismatch)
        throw DataError(
            retry.folder, "tick " + std::to_string(result.first_mismatch->ticks),
            "replaying gives another result than recorded; use the program version that recorded it");
}

bool haveSameForceLimits(const haptics::DeviceProfile& a, const haptics::DeviceProfile& b) {
    // Unknown values are NaN. Two NaNs count as equal.
    const auto same = [](double x, double y) {
        return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y) || (x != x && y != y);
    };
    bool all = same(a.force_peak_n, b.force_peak_n) && same(a.stiffness_n_per_m, b.stiffness_n_per_m) &&
               same(a.mass_kg, b.mass_kg) && same(a.delay_s, b.delay_s) &&
               same(a.workspace_radius_m, b.workspace_radius_m);
    for (int i = 0; i < 3; ++i)
        all = all && same(a.workspace_centre_m[i], b.workspace_centre_m[i]);
    return all;
}

void startFromRecord(Attempt& attempt, const Retry& retry, const MakeTouch& make_touch) {
    const haptics::SimulationSettings& recorded = retry.record.header.settings;
    const Pose recorded_from_device =
        recorded.patient_from_device.inverse() * attempt.simulation.patient_from_device;
    const bool same =
        recorded.patient_from_device.position_m == attempt.simulation.patient_from_device.position_m &&
        recorded.patient_from_device.rotation == attempt.simulation.patient_from_device.rotation;
    if (!same)
        for (haptics::TraceSample& sample : attempt.hand.samples)
            sample.device_from_stylus = recorded_from_device * sample.device_from_stylus;
    attempt.simulation = recorded;
    attempt.beginning = retry.record.inputs;
    bool presses = haptics::pressesOnSkin(recorded.tools.first), uses_wire = false;
    for (const haptics::TickInput& input : attempt.beginning)
        for (std::uint32_t i = 0; i < input.command_count; ++i)
            presses = presses || haptics::selectsSkinTool(input.commands[i]),
            uses_wire = uses_wire || haptics::selectsAccessTool(input.commands[i]);
    if (uses_wire && !attempt.ducts) attempt.ducts = patient::makeDuctSpace(attempt.patient);
    if (presses && !attempt.touch) attempt.touch = make_touch(attempt.patient);
}

}  // namespace stylet::trainer
