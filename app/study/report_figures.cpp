#include "app/study/report_figures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/study/report_tables.h"

namespace stylet::study {

using report::Colour;
using report::Figure;
using report::FigurePoint;
using report::FigureSeries;
using report::fixed;
using report::kGap;
using report::Table;

namespace {

constexpr std::size_t kMaxDots = 150;  // outliers drawn per patient
constexpr double kFewPaths = 0.02;     // tissues that fewer paths meet are not drawn

const std::array<Colour, 6> kPalette{report::kBlue,   report::kVermilion, report::kGreen,
                                     report::kPurple, report::kOrange,    report::kSky};

// One dash pattern for each pass through the palette.
const std::array<std::vector<int>, 4> kDashes{{{}, {6, 3}, {2, 2}, {8, 2, 2, 2}}};

std::string thresholdText(double value, const std::string& axis) {
    return "just noticeable: " + numberText(value, 3) + axis.substr(axis.rfind(' '));
}

// High enough for every whisker and threshold. Rare larger values may lie above the axis.
double axisTop(const ReportedStudy& study, const PathNumber& number) {
    double top = 0.0;
    forEachSummary(study, [&](const std::string&, const Summary& s, const Summary&) {
        const double whisker = number.spread(s).upper_whisker;
        if (std::isfinite(whisker)) top = std::max(top, number.unit * whisker);
    });
    for (const double t : number.thresholds)
        top = std::max(top, t);
    return 1.25 * top;
}

// At most kMaxDots of the values, evenly spaced, including the largest.
void addDots(std::vector<double> values, double x, FigureSeries& dots) {
    std::sort(values.begin(), values.end());
    const std::size_t count = std::min(values.size(), kMaxDots);
    for (std::size_t i = 0; i < count; ++i)
        dots.points.push_back({x, values[(i + 1) * values.size() / count - 1], {}});
}

std::vector<std::string> spreadRow(const std::string& name, const Spread& s, double unit, int digits) {
    std::vector<std::string> row{name, countText(s.count)};
    for (const double v : {s.mean, s.sigma, s.lower_whisker, s.lower_quartile, s.median, s.upper_quartile,
                           s.upper_whisker, s.max})
        row.push_back(fixed(unit * v, digits));
    row.push_back(percentText(s.outlier_share, 2));
    row.push_back(percentText(s.above_whisker_share, 2));
    return row;
}

const std::vector<std::string> kSpreadHead{"Patient",
                                           "Paths",
                                           "Mean",
                                           "Standard deviation",
                                           "Lower whisker",
                                           "Lower quartile",
                                           "Median",
                                           "Upper quartile",
                                           "Upper whisker",
                                           "Largest",
                                           "Above mean + 2.7 sigma",
                                           "Above the whisker"};
const std::vector<bool> kSpreadNumbers{false, true, true, true, true, true,
                                       true,  true, true, true, true, true};

}  // namespace

std::string countText(std::size_t n) {
    std::string text = std::to_string(n);
    for (std::size_t i = text.size(); i > 3; i -= 3)
        text.insert(i - 3, ",");
    return text;
}

std::string percentText(double share, int digits) {
    const std::string number = fixed(100.0 * share, digits);
    return std::isfinite(share) ? number + " %" : number;
}

Plot boxPlot(const ReportedStudy& study, const PathNumber& number) {
    Plot plot;
    Figure& f = plot.figure;
    const double top = axisTop(study, number);
    f.y = {number.axis, 0.0};
    if (top > 0.0) f.y.max = top;
    plot.numbers = {number.axis + ": over the paths", kSpreadHead, {}, kSpreadNumbers, true};
    FigureSeries dots{"paths beyond the whiskers", report::kPurple};
    dots.line = false, dots.shape = "circle", dots.small = true;
    FigureSeries means{"mean of the paths that meet no bone", report::kVermilion};
    means.line = false, means.shape = "rectRot";
    const auto values = [&](const std::vector<PathResult>& results, const Spread& s,
                            std::vector<double>& out) {
        for (const PathResult& r : results) {
            const double v = number.value(r);
            if (!(v > s.upper_whisker || v < s.lower_whisker)) continue;
            if (number.unit * v <= top)
                out.push_back(number.unit * v);
            else
                ++plot.beyond;
        }
    };
    double x = 0.0;
    forEachSummary(study, [&](const std::string& name, const Summary& summary, const Summary& clear) {
        const Spread& s = number.spread(summary);
        f.x.names.push_back(name);
        plot.numbers.rows.push_back(spreadRow(name, s, number.unit, number.digits));
        if (s.count > 0) {
            const double u = number.unit;
            f.boxes.push_back({x, u * s.lower_whisker, u * s.lower_quartile, u * s.median,
                               u * s.upper_quartile, u * s.upper_whisker,
                               x == 0.0 ? report::kBlack : report::kBlue});
            const double mean = u * number.spread(clear).mean;
            if (mean <= top) means.points.push_back({x, mean, {}});
            std::vector<double> outliers;
            if (x > 0.0) values(study.pairs[std::size_t(x) - 1].results, s, outliers);
            if (!outliers.empty()) addDots(std::move(outliers), x, dots);
        }
        x += 1.0;
    });
    for (const double t : number.thresholds)
        f.lines.push_back({t, thresholdText(t, number.axis)});
    f.series = {std::move(dots), std::move(means)};
    return plot;
}

Plot borderPlot(const ReportedStudy& study, const std::string& axis,
                const Spread& (*spread)(const TissueSummary&), const std::vector<double>& thresholds_mm) {
    Plot plot;
    Figure& f = plot.figure;
    plot.numbers = {axis + ", by tissue", kSpreadHead, {}, kSpreadNumbers, true};
    plot.numbers.head.insert(plot.numbers.head.begin() + 1, "Tissue");
    plot.numbers.number.insert(plot.numbers.number.begin() + 1, false);
    std::vector<std::size_t> tissues;
    for (std::size_t t = 1; t < study.all.tissues.size(); ++t)
        if (double(spread(study.all.tissues[t]).count) > kFewPaths * double(study.all.paths))
            tissues.push_back(t);
    for (const std::size_t t : tissues)
        f.x.names.emplace_back(patient::tissueName(patient::Tissue(t)));
    double top = thresholds_mm.empty() ? 1.0 : thresholds_mm.back();
    forEachSummary(study, [&](const std::string&, const Summary& s, const Summary&) {
        for (const std::size_t t : tissues)
            if (t < s.tissues.size() && spread(s.tissues[t]).count > 0) {
                const Spread& v = spread(s.tissues[t]);
                top = std::max(top, kMm * (v.count > 1 ? v.mean + v.sigma : v.mean));
            }
    });
    forEachSummary(study, [&](const std::string& name, const Summary& s, const Summary&) {
        FigureSeries means{"mean", report::kBlue}, bars{"one standard deviation", report::kBlue};
        means.line = false, means.shape = "circle";
        for (std::size_t place = 0; place < tissues.size() && !s.tissues.empty(); ++place) {
            const Spread& v = spread(s.tissues[tissues[place]]);
            if (v.count == 0) continue;
            const auto x = double(place);
            means.points.push_back({x, kMm * v.mean, {}});
            if (v.count > 1) {
                bars.points.push_back({x, std::max(0.0, kMm * (v.mean - v.sigma)), {}});
                bars.points.push_back({x, kMm * (v.mean + v.sigma), {}});
                bars.points.push_back({x, kGap, {}});
            }
            std::vector<std::string> row = spreadRow(name, v, kMm, 2);
            row.insert(row.begin() + 1, f.x.names[place]);
            plot.numbers.rows.push_back(std::move(row));
        }
        f.choices.push_back({name, {axis, 0.0, 1.1 * top}, {std::move(means), std::move(bars)}});
    });
    for (const double t : thresholds_mm)
        f.lines.push_back({t, thresholdText(t, axis)});
    return plot;
}

Plot positionPlot(const ReportedStudy& study) {
    Plot plot;
    Figure& f = plot.figure;
    f.x = {"share of the way from the skin to the target, %", 0.0, 100.0};
    f.y = {"RMSE, N", 0.0};
    plot.numbers = {"RMSE along the way, N, of the paths that meet no bone", {"Patient"}, {}, {false}, false};
    for (int bin = 0; bin < kPositionBins; ++bin) {
        plot.numbers.head.push_back(std::to_string(100 * bin / kPositionBins) + "–" +
                                    std::to_string(100 * (bin + 1) / kPositionBins) + " %");
        plot.numbers.number.push_back(true);
    }
    const auto add = [&](const std::string& name, const Summary& s, Colour colour, double width,
                         const std::vector<int>& dash) {
        if (s.paths == 0) return;
        FigureSeries line{name, colour};
        line.width = width, line.dash = dash;
        std::vector<std::string> row{name};
        for (std::size_t bin = 0; bin < kPositionBins; ++bin) {
            line.points.push_back({100.0 * (double(bin) + 0.5) / kPositionBins, s.position_rmse_n[bin], {}});
            row.push_back(fixed(s.position_rmse_n[bin], 3));
        }
        f.series.push_back(std::move(line));
        plot.numbers.rows.push_back(std::move(row));
    };
    add("all", study.without_bone, report::kBlack, 3.5, {});
    for (std::size_t i = 0; i < study.pairs.size(); ++i)
        add(study.pairs[i].name, study.pairs[i].without_bone, kPalette[i % kPalette.size()],
            isSynthetic(study.pairs[i].facts) ? 1.5 : 2.5, kDashes[i / kPalette.size() % kDashes.size()]);
    return plot;
}

Plot scorePlot(const ReportedStudy& study) {
    Plot plot;
    plot.numbers = {"Kept paths by score", {"Patient", "Score"}, {}, {false, false}, false};
    struct Score {
        const char* name;
        const std::vector<std::size_t> PlanFacts::* bins;
        Colour colour;
        std::vector<int> dash;
    };
    const std::array<Score, 4> scores{
        {{"C3, clearance", &PlanFacts::c3, report::kBlue, {}},
         {"C4, way in the duct", &PlanFacts::c4, report::kVermilion, {6, 3}},
         {"Q", &PlanFacts::quality, report::kBlack, {2, 2}},
         {"worst Q of a breath", &PlanFacts::worst_quality, report::kGreen, {8, 2, 2, 2}}}};
    const bool breathed = std::any_of(study.pairs.begin(), study.pairs.end(),
                                      [](const ReportedPair& p) { return !p.plan.worst_quality.empty(); });
    std::size_t bins = 0;
    for (const ReportedPair& pair : study.pairs)
        bins = std::max(bins, pair.plan.quality.size());
    for (std::size_t b = 0; b < bins; ++b) {
        plot.numbers.head.push_back(fixed(double(b) / double(bins), 2) + "–" +
                                    fixed(double(b + 1) / double(bins), 2));
        plot.numbers.number.push_back(true);
    }
    const auto add = [&](const std::string& name, std::span<const ReportedPair> pairs) {
        report::FigureChoice choice{name, {"paths", 0.0}, {}};
        choice.y.whole = true;
        for (const Score& score : scores) {
            if (score.bins == &PlanFacts::worst_quality && !breathed) continue;
            std::vector<std::size_t> sum(bins);
            for (const ReportedPair& pair : pairs)
                for (std::size_t b = 0; b < (pair.plan.*score.bins).size(); ++b)
                    sum[b] += (pair.plan.*score.bins)[b];
            FigureSeries outline{score.name, score.colour};
            outline.dash = score.dash;
            outline.points.push_back({0.0, 0.0, {}});
            std::vector<std::string> row{name, score.name};
            for (std::size_t b = 0; b < bins; ++b) {
                for (const std::size_t edge : {b, b + 1})
                    outline.points.push_back({double(edge) / double(bins), double(sum[b]), {}});
                row.push_back(countText(sum[b]));
            }
            outline.points.push_back({1.0, 0.0, {}});
            choice.series.push_back(std::move(outline));
            plot.numbers.rows.push_back(std::move(row));
        }
        plot.figure.choices.push_back(std::move(choice));
    };
    plot.figure.x = {"score", 0.0, 1.0};
    add("all", study.pairs);
    for (const ReportedPair& pair : study.pairs)
        add(pair.name, std::span(&pair, 1));
    return plot;
}

}  // namespace stylet::study
