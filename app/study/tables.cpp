#include "app/study/tables.h"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "base/whole_file.h"

namespace stylet::study {

using patient::PlannedPath;

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr std::size_t kScoreBins = 20;  // equal bins of [0, 1]

// Rows of a CSV table.
class Rows {
  public:
    explicit Rows(const std::string& header) : text_(header + "\n") {}
    Rows& operator<<(double v) { return cell(std::isfinite(v) ? shortestText(v) : ""); }
    Rows& operator<<(std::size_t v) { return cell(std::to_string(v)); }
    Rows& operator<<(std::string_view v) { return cell(v); }
    void end() {
        text_ += '\n';
        first_ = true;
    }
    const std::string& text() const { return text_; }

  private:
    Rows& cell(std::string_view v) {
        if (!first_) text_ += ',';
        first_ = false;
        text_ += v;
        return *this;
    }
    std::string text_;
    bool first_ = true;
};

void addMm(Rows& rows, const Vec3& p) {
    rows << kMm * p.x << kMm * p.y << kMm * p.z;
}

// In the order of the enumerators. "held" means tenting; the file format keeps the older name.
constexpr std::array<std::string_view, 6> kEventNames{"held",     "cut",       "entry",
                                                      "sideways", "withdrawn", "overflow"};
constexpr std::array<std::string_view, 3> kModelNames{"full", "partial", ""};

// ---- JSON

Json orNull(double v) {
    return std::isfinite(v) ? Json(v) : Json(nullptr);
}

Json toJson(const Spread& s, double unit = 1.0) {
    return {{"count", s.count},
            {"mean", orNull(unit * s.mean)},
            {"sigma", orNull(unit * s.sigma)},
            {"least", orNull(unit * s.min)},
            {"lower_whisker", orNull(unit * s.lower_whisker)},
            {"lower_quartile", orNull(unit * s.lower_quartile)},
            {"median", orNull(unit * s.median)},
            {"upper_quartile", orNull(unit * s.upper_quartile)},
            {"upper_whisker", orNull(unit * s.upper_whisker)},
            {"most", orNull(unit * s.max)},
            {"outlier_limit", orNull(unit * s.outlier_limit)},
            {"outlier_share", s.outlier_share},
            {"above_whisker_share", s.above_whisker_share}};
}

Json toJson(const std::vector<CauseCount>& causes) {
    Json list = Json::array();
    for (const CauseCount& c : causes)
        list.push_back({{"tissue", patient::tissueName(c.cause.tissue)},
                        {"event", enumName(kEventNames, c.cause.kind)},
                        {"of", enumName(kModelNames, c.cause.model)},
                        {"paths", c.paths},
                        {"median_apart_mm", orNull(kMm * c.cause.offset_m)}});
    return list;
}

Json toJson(const TissueSummary& t) {
    return {{"tissue", patient::tissueName(t.tissue)},
            {"mean_distance_mm", toJson(t.mean_distance_m, kMm)},
            {"hausdorff_mm", toJson(t.hausdorff_m, kMm)},
            {"event_error_mm", toJson(t.event_error_m, kMm)},
            {"event_offset_mm", orNull(kMm * t.event_offset_m)},
            {"missed_paths", t.missed},
            {"invented_paths", t.invented},
            {"error_share", t.error_share}};
}

Json toJson(const Summary& s) {
    Json json = {{"name", s.name},
                 {"paths", s.paths},
                 {"samples", s.samples},
                 {"rmse_n", toJson(s.rmse_n)},
                 {"max_n", toJson(s.max_n)},
                 {"equal_share", toJson(s.equal_share)},
                 {"max_outside_events_n", toJson(s.max_outside_n)},
                 {"pooled_rmse_n", orNull(s.pooled_rmse_n)},
                 {"exact",
                  {{"rmse_n", toJson(s.exact_rmse_n)},
                   {"max_n", toJson(s.exact_max_n)},
                   {"equal_share", toJson(s.exact_equal_share)}}},
                 {"mean_distance_mm", toJson(s.mean_distance_m, kMm)},
                 {"hausdorff_mm", toJson(s.hausdorff_m, kMm)},
                 {"paths_above_0.145_n", s.rmse_noticed_share},
                 {"paths_above_2_mm", s.distance_noticed_share},
                 {"paths_hausdorff_above_3_mm", s.hausdorff_noticed_share},
                 {"same_order_share", s.same_order_share},
                 {"same_order_inside_share", s.same_order_inside_share},
                 {"same_order_noticeable_share", s.same_order_noticeable_share},
                 {"bone_paths", s.bone_paths},
                 {"missed_paths", s.missed_paths},
                 {"invented_paths", s.invented_paths},
                 {"position_rmse_n", s.position_rmse_n}};
    for (const TissueSummary& t : s.tissues)
        json["tissues"].push_back(toJson(t));
    json["causes"] = toJson(s.causes);
    json["outlier_causes"] = toJson(s.outlier_causes);
    return json;
}

void count(std::vector<std::size_t>& bins, double score) {
    ++bins[std::min(kScoreBins - 1, std::size_t(score * double(kScoreBins)))];
}

template <typename Score>
Json histogram(const std::vector<PlannedPath>& paths, const Score& score) {
    std::vector<std::size_t> bins(kScoreBins);
    for (const PlannedPath& p : paths)
        count(bins, score(p));
    return bins;
}

}  // namespace

void writePlanTable(const fs::path& csv, const PairPlan& plan) {
    Rows rows(
        "path,entry_x_mm,entry_y_mm,entry_z_mm,target_x_mm,target_y_mm,target_z_mm,length_mm,c3,c4,quality,"
        "worst_quality");
    for (std::size_t i = 0; i < plan.result.paths.size(); ++i) {
        const PlannedPath& p = plan.result.paths[i];
        rows << i;
        addMm(rows, p.entry_reference_m);
        addMm(rows, p.target_reference_m);
        rows << kMm * p.length_m << p.clearance_score << p.target_score << p.quality
             << (plan.worst_quality.empty() ? kNone : plan.worst_quality[i]);
        rows.end();
    }
    writeWholeFile(csv, rows.text());
}

void writePlanSummary(const fs::path& json, const PairPlan& plan, const PlanRequest& request,
                      const std::vector<std::string>& implausible) {
    const patient::PlanResult& r = plan.result;
    Json out = {{"format", "stylet study plan 1"},
                {"planner_version", patient::kPlannerVersion},
                {"skin_spacing_mm", kMm * request.skin_spacing_m},
                {"target_spacing_mm", kMm * request.target_spacing_m},
                {"breaths", request.breaths},
                {"candidates", r.candidates},
                {"skipped", r.skipped},
                {"blocked", r.rejected_blocked},
                {"too_long", r.rejected_long},
                {"poor", r.rejected_quality},
                {"kept", r.paths.size()},
                {"c3", histogram(r.paths, [](const PlannedPath& p) { return p.clearance_score; })},
                {"c4", histogram(r.paths, [](const PlannedPath& p) { return p.target_score; })},
                {"quality", histogram(r.paths, [](const PlannedPath& p) { return p.quality; })}};
    if (!plan.worst_quality.empty()) {
        std::vector<std::size_t> bins(kScoreBins);
        for (const double q : plan.worst_quality)
            count(bins, q);
        out["worst_quality"] = bins;
    }
    if (!implausible.empty()) out["implausible"] = implausible;
    writeWholeFile(json, out.dump(1) + "\n");
}

void writePathTable(const fs::path& csv, const PairFindings& f) {
    std::string header =
        "path,entry_x_mm,entry_y_mm,entry_z_mm,target_x_mm,target_y_mm,target_z_mm,length_mm,quality,samples,"
        "rmse_n,max_n,max_at_mm,equal_share,max_outside_events_n,exact_rmse_n,exact_max_n,exact_equal_share,"
        "same_order,same_order_inside,same_order_noticeable,meets_bone,mean_distance_mm,hausdorff_mm,missed,"
        "invented,cause_tissue,"
        "cause_event,cause_of,cause_apart_mm";
    for (std::size_t t = 1; t < kTissues; ++t)
        header += fmt::format(",{0}_mean_mm,{0}_hausdorff_mm,{0}_event_mm", patient::kTissueNames[t]);
    Rows rows(header);
    for (std::size_t i = 0; i < f.results.size(); ++i) {
        const PlannedPath& p = f.paths[i];
        const PathResult& r = f.results[i];
        rows << i;
        addMm(rows, p.entry_reference_m);
        addMm(rows, p.target_reference_m);
        rows << kMm * p.length_m << p.quality << std::size_t(r.samples) << r.sampled.rmse_n << r.sampled.max_n
             << kMm * r.sampled.max_at_m << r.sampled.equal_share << r.max_outside_n << r.exact.rmse_n
             << r.exact.max_n << r.exact.equal_share << std::size_t(r.same_order)
             << std::size_t(r.same_order_inside) << std::size_t(r.same_order_noticeable)
             << std::size_t(r.meets_bone) << kMm * r.borders.mean_m << kMm * r.borders.hausdorff_m
             << std::size_t(r.borders.missed) << std::size_t(r.borders.invented);
        const bool caused = r.cause.model != Model::neither;
        rows << (caused ? patient::tissueName(r.cause.tissue) : "")
             << (caused ? enumName(kEventNames, r.cause.kind) : "") << enumName(kModelNames, r.cause.model)
             << kMm * r.cause.offset_m;
        for (std::size_t t = 1; t < kTissues; ++t)
            rows << kMm * r.by_tissue[t].mean_m << kMm * r.by_tissue[t].hausdorff_m << kMm * r.event_m[t];
        rows.end();
    }
    writeWholeFile(csv, rows.text());
}

void writeSampleTable(const fs::path& csv, const PreparedPair& pair, std::span<const PlannedPath> paths,
                      const SteeringSettings& settings) {
    Rows rows("path,depth_mm,full_n,partial_n");
    Steering steering(pair, settings);
    for (std::size_t path = 0; path < paths.size(); ++path) {
        const SteeringResult* const s = steering.steer(paths[path]);
        if (!s) continue;
        for (std::size_t i = 0; i < s->full.samples_n.size(); ++i) {
            rows << path << kMm * (s->first_m + double(i) * s->step_m - s->entry_m) << s->full.samples_n[i]
                 << s->partial.samples_n[i];
            rows.end();
        }
    }
    writeWholeFile(csv, rows.text());
}

void writeSummary(const fs::path& json, std::span<const PairFindings> findings, const RunSettings& settings,
                  FoundLabels labels) {
    const SteeringSettings& steering = settings.steering;
    Json out = {{"format", "stylet study 1"},
                {"planner_version", patient::kPlannerVersion},
                {"settings",
                 {{"samples", steering.samples},
                  {"max_spacing_mm", kMm * steering.max_spacing_m},
                  {"a1_share", steering.needle.a1_share},
                  {"cut_reach_mm", kMm * steering.needle.cut_reach_m},
                  {"max_force_n", steering.needle.max_force_n},
                  {"breathing", steering.breathing},
                  {"speed_mm_per_s", kMm * steering.speed_m_s},
                  {"event_window_mm", kMm * settings.measure.event_window_m},
                  {"found_labels", labels == FoundLabels::all ? "all" : "partial"}}}};
    std::vector<PathResult> all;
    std::vector<Summary> patients;
    for (const PairFindings& f : findings) {
        all.insert(all.end(), f.results.begin(), f.results.end());
        patients.push_back(f.summary);
        Json patient = toJson(f.summary);
        patient["reference_labelled_share"] = f.reference_share;
        out["patients"].push_back(std::move(patient));
    }
    out["all"] = toJson(summarise("all", all));
    std::erase_if(all, [](const PathResult& r) { return r.meets_bone; });
    out["all_without_bone"] = toJson(summarise("all without bone", all));
    const Cohort cohort = computeCohort(patients);
    out["patients_means"] = {{"rmse_n", toJson(cohort.rmse_n)},
                             {"max_n", toJson(cohort.max_n)},
                             {"equal_share", toJson(cohort.equal_share)}};
    writeWholeFile(json, out.dump(1) + "\n");
}

}  // namespace stylet::study
