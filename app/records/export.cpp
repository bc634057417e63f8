#include "app/records/export.h"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/records/record.h"
#include "base/csv.h"
#include "base/hex.h"
#include "base/text.h"
#include "base/whole_file.h"
#include "patient/package/package.h"

namespace stylet::records {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

// In the order of haptics::Phase.
constexpr std::array<std::string_view, 3> kPhaseNames{"outside", "held", "pass"};

std::string numberText(double v) {
    return fmt::format("{:.17g}", v);
}

// A CSV file, written line by line.
class CsvFile {
  public:
    CsvFile(const fs::path& file, const std::string& columns) : file_(file), text_(columns + "\r\n") {}
    void add(const std::vector<std::string>& cells) { text_ += csvRow(cells) + "\r\n"; }
    void close() { writeWholeFile(file_, text_); }

  private:
    fs::path file_;
    std::string text_;
};

ordered_json numberJson(double v) {
    return std::isfinite(v) ? ordered_json(v) : ordered_json(nullptr);
}

std::string unchanged(std::string text) {
    return text;
}

void copyFiles(const Store& store, const StoredAttempt& attempt, const fs::path& to, ExportResult& exported) {
    createPrivateFolders(to);
    for (const StoredFile& stored : store.files(attempt.id)) {
        const fs::path from = attempt.folder / stored.file;
        if (!fs::exists(from)) {
            exported.damage.push_back(from.string() + ": is gone");
            continue;
        }
        createPrivateFolders((to / stored.file).parent_path());
        fs::copy_file(from, to / stored.file);
        if (computeChecksum(to, stored.file) != stored)
            exported.damage.push_back(from.string() + ": its checksum does not match");
    }
    writeWholeFile(to / "attempt.json", attemptJson(attempt, numberJson, unchanged)
                                                .dump(2, ' ', false, ordered_json::error_handler_t::replace) +
                                            '\n');
}

void writeTables(const std::vector<StoredAttempt>& attempts, const fs::path& folder) {
    CsvFile index(folder / "attempts.csv",
                  "id,trainee,started_utc,state,device,patient,patient_digest,scenario,difficulty,"
                  "program_version,seed,dt_s,device_gain,registration_rms_m,target_hit,total,ticks,aborted,"
                  "score_version,imported");
    CsvFile metrics(folder / "metrics.csv", "attempt,id,name,unit,value,points,most_points");
    CsvFile events(folder / "events.csv", "attempt,tick,kind,text");
    for (const StoredAttempt& a : attempts) {
        index.add({a.id,
                   a.info.trainee,
                   a.started_utc,
                   std::string(stateName(a.state)),
                   a.info.device,
                   a.info.patient,
                   hexText(a.info.patient_digest),
                   a.info.scenario,
                   a.info.difficulty,
                   a.info.program_version,
                   std::to_string(a.info.seed),
                   numberText(a.info.dt_s),
                   numberText(a.info.device_gain),
                   a.info.registration_rms_m ? numberText(*a.info.registration_rms_m) : "",
                   a.result ? (a.result->target_hit ? "1" : "0") : "",
                   a.result ? numberText(a.result->total) : "",
                   a.result ? std::to_string(a.result->ticks) : "",
                   a.result ? (a.result->aborted ? "1" : "0") : "",
                   a.result ? std::to_string(a.result->score_version) : "",
                   a.imported ? "1" : "0"});
        for (const MetricRow& m : a.result ? a.result->metrics : std::vector<MetricRow>{})
            metrics.add({a.id, m.id, m.name, m.unit, numberText(m.value), numberText(m.points),
                         numberText(m.max_points)});
        for (const EventRow& e : a.events)
            events.add({a.id, std::to_string(e.tick), e.kind, e.text});
    }
    index.close(), metrics.close(), events.close();
}

void writeChecksums(const fs::path& folder) {
    std::vector<StoredFile> sums = computeChecksums(folder);
    CsvFile table(folder / "checksums.csv", "path,bytes,crc32");
    for (const StoredFile& sum : sums)
        table.add({sum.file.generic_string(), std::to_string(sum.bytes), hexText(sum.crc32, 8)});
    table.close();
}

}  // namespace

ordered_json attemptJson(const StoredAttempt& a, ordered_json (*number)(double),
                         std::string (*text)(std::string)) {
    ordered_json j{{"id", text(a.id)},
                   {"trainee", text(a.info.trainee)},
                   {"started_utc", text(a.started_utc)},
                   {"state", stateName(a.state)},
                   {"device", text(a.info.device)},
                   {"patient", text(a.info.patient)},
                   {"patient_digest", hexText(a.info.patient_digest)},
                   {"scenario", text(a.info.scenario)},
                   {"difficulty", text(a.info.difficulty)},
                   {"program_version", text(a.info.program_version)},
                   {"seed", a.info.seed},
                   {"dt_s", number(a.info.dt_s)},
                   {"device_gain", number(a.info.device_gain)},
                   {"registration_rms_m", nullptr}};
    if (a.info.registration_rms_m) j["registration_rms_m"] = number(*a.info.registration_rms_m);
    j["imported"] = a.imported;
    ordered_json metrics = ordered_json::array(), events = ordered_json::array();
    if (a.result) {
        j["target_hit"] = a.result->target_hit;
        j["total"] = number(a.result->total);
        j["ticks"] = a.result->ticks;
        j["aborted"] = a.result->aborted;
        j["score_version"] = a.result->score_version;
        for (const MetricRow& m : a.result->metrics)
            metrics.push_back({{"id", text(m.id)},
                               {"name", text(m.name)},
                               {"unit", text(m.unit)},
                               {"value", number(m.value)},
                               {"points", number(m.points)},
                               {"most_points", number(m.max_points)}});
    }
    for (const EventRow& e : a.events)
        events.push_back({{"tick", e.tick}, {"kind", text(e.kind)}, {"text", text(e.text)}});
    j["metrics"] = metrics;
    j["events"] = events;
    return j;
}

void exportSummary(const RecordInfo& info, const ordered_json& performance, const fs::path& file) {
    ordered_json j{{"patient", info.patient_name},
                   {"scenario", info.scenario},
                   {"seed", info.seed},
                   {"clock", info.clock},
                   {"device", info.device},
                   {"firmware_sha256", info.firmware_sha256},
                   {"path", {{"length_m", info.path.length_m}, {"quality", info.path.quality}}}};
    j.update(resultJson(info.result.value()));
    if (!j.contains("force_truth")) j["force_truth"] = "no full segmentation of this patient";
    j.update(performance);
    j["state_hash"] = hexText(info.end.value().state_hash);
    writeWholeFile(file, j.dump(2, ' ', false, ordered_json::error_handler_t::replace) + '\n');
}

void exportCurve(const std::vector<ForceSample>& curve, double dt_s, const fs::path& file) {
    std::string text = "tick,time_s,depth_m,force_n,phase,tissue,breath_held\n";
    for (const ForceSample& s : curve)
        text += fmt::format("{},{:.3f},{:.7f},{:.6f},{},{},{:d}\n", s.tick, double(s.tick) * dt_s, s.depth_m,
                            s.force_n, enumName(kPhaseNames, s.phase), patient::tissueName(s.tissue),
                            s.breath_held);
    writeWholeFile(file, text);
}

ExportResult exportAttempts(const Store& store, const std::string& trainee, const fs::path& folder) {
    try {
        createPrivateFolders(folder);
        if (!fs::is_empty(folder)) throw DataError(folder, "folder", "is not empty");
        makeTreePrivate(folder);  // it may have been there before
        ExportResult exported;
        std::vector<StoredAttempt> attempts = store.attempts(trainee);
        for (const StoredAttempt& attempt : attempts)
            if (attempt.state == AttemptState::running) exported.left_out.push_back(attempt.id);
        std::erase_if(attempts, [](const StoredAttempt& a) { return a.state == AttemptState::running; });
        for (const StoredAttempt& attempt : attempts)
            copyFiles(store, attempt, folder / "attempts" / attempt.id, exported);
        writeTables(attempts, folder);
        writeChecksums(folder);
        makeTreePrivate(folder);
        exported.attempts = attempts.size();
        return exported;
    } catch (const fs::filesystem_error& e) {
        throw DataError(e.path1(), "file", e.code().message());
    }
}

}  // namespace stylet::records
