// Computes the surrogate from a marker's track: its first principal axis, scaled by the median breath. The
// result is hashed: no libm transcendentals.
#include "patient/motion/recording.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <string>

#include "base/csv.h"
#include "base/errors.h"
#include "base/geometry.h"
#include "base/statistics.h"
#include "base/whole_file.h"

namespace stylet::patient {
namespace {

constexpr std::size_t kMaxRecordingBytes = 16 << 20;
constexpr std::size_t kMaxRows = 200'000;
constexpr double kMaxRecording_s = 3600.0, kMaxMarkerDistance_m = 10.0;
constexpr double kDt_s = 0.1;
constexpr double kMaxGap_s = 0.5;           // largest gap between accepted rows
constexpr double kMaxMisdatedShare = 0.02;  // maximum share of misdated rows
constexpr double kMinTravel_m = 0.0005;     // anything less is camera noise
constexpr double kMaxRecorded_v = 20.0;     // deeper than any sigh
constexpr int kMinBreaths = 2;
constexpr double kMinTurn = 0.35;    // share of the usual range that separates a minimum from a maximum
constexpr std::size_t kWindow = 80;  // samples; long enough to contain a whole breath

struct RecordingRow {
    double t_s = 0.0;
    Vec3 p_m{0.0};
    bool zero = false;
};

// A number with a decimal comma or point.
std::optional<double> number(std::string_view text) {
    if (text.size() > 40) return std::nullopt;  // no camera writes so many digits
    std::string point(text);
    std::replace(point.begin(), point.end(), ',', '.');
    const auto value = parseNumber<double>(point);
    if (!value || !std::isfinite(*value)) return std::nullopt;
    return value;
}

RecordingRow readRow(CsvReader& in) {
    std::array<double, 5> values{};
    for (double& value : values) {
        const auto read = number(in.text());
        if (!read) in.refuse("not a number");
        value = *read;
    }
    RecordingRow row{values[1] * 1e-3, Vec3(values[2], values[3], values[4]) * 1e-3, false};
    for (int k = 0; k < 3; ++k)
        if (!(std::fabs(row.p_m[k]) <= kMaxMarkerDistance_m))
            in.refuseRow("the marker is farther than 10 m from the origin");
    if (!(row.t_s >= 0.0 && row.t_s <= kMaxRecording_s)) in.refuseRow("the time is not from 0 to 3600 s");
    row.zero = std::all_of(values.begin(), values.end(), [](double v) { return v == 0.0; });
    return row;
}

std::vector<RecordingRow> readRows(std::string_view csv, const std::filesystem::path& file) {
    csv = csv.substr(0, csv.find_last_not_of("\r\n") + 1);  // recordings may end with blank lines
    CsvReader in(file, csv,
                 csv.starts_with('"') ? R"("Frame";"Timestamp";"x";"y";"z")" : "Frame;Timestamp;x;y;z", ';');
    std::vector<RecordingRow> rows;
    while (in.next()) {
        if (rows.size() == kMaxRows) in.refuseRow(fmt::format("more than {} rows", kMaxRows));
        rows.push_back(readRow(in));
    }
    return rows;
}

// Keeps rows in time order. Drops a row whose time is before its predecessor's or far ahead of it.
std::vector<RecordingRow> dropMisdatedRows(const std::vector<RecordingRow>& rows,
                                           const std::filesystem::path& file, int& misdated) {
    std::vector<RecordingRow> kept{rows.front()};
    for (std::size_t i = 0; i < rows.size(); ++i) {
        if (rows[i].zero)
            throw DataError(file, fmt::format("line {}", i + 2), "a row of zeros between measured rows");
        if (i == 0) continue;
        const double gap_s = rows[i].t_s - kept.back().t_s;
        if (gap_s > 0.0 && gap_s <= kMaxGap_s)
            kept.push_back(rows[i]);
        else
            ++misdated;
    }
    if (double(misdated) > kMaxMisdatedShare * double(rows.size()))
        throw DataError(file, "Timestamp",
                        fmt::format("{} of {} rows break the order of time or leave a gap above 0.5 s",
                                    misdated, rows.size()));
    return kept;
}

// Unit vector of the largest variance, by power iteration, oriented toward +z.
Vec3 principalAxis(const std::vector<RecordingRow>& rows) {
    Vec3 mean(0.0);
    for (const RecordingRow& row : rows)
        mean += row.p_m / double(rows.size());
    glm::dmat3 covariance(0.0);
    for (const RecordingRow& row : rows)
        covariance += glm::outerProduct(row.p_m - mean, row.p_m - mean);
    // Start with the column of the largest diagonal element. It is never orthogonal to the wanted axis.
    int widest = 0;
    for (int k = 1; k < 3; ++k)
        if (covariance[k][k] > covariance[widest][widest]) widest = k;
    Vec3 axis = covariance[widest];
    for (int i = 0; i < 200; ++i) {
        const double length = glm::length(axis);
        if (!(length > 0.0)) return {0.0, 0.0, 1.0};
        axis = covariance * (axis / length);
    }
    return axis / (axis.z < 0.0 ? -glm::length(axis) : glm::length(axis));
}

// Position along `axis` every kDt_s, smoothed to remove the camera's quantisation (binomial over five
// samples: loses 2 % at 0.3 Hz).
std::vector<double> resampled(const std::vector<RecordingRow>& rows, const Vec3& axis) {
    const auto along = [&](const RecordingRow& r) { return glm::dot(r.p_m - rows.front().p_m, axis); };
    std::vector<double> raw;
    std::size_t i = 0;
    for (std::size_t k = 0;; ++k) {
        const double t_s = rows.front().t_s + double(k) * kDt_s;
        if (t_s > rows.back().t_s) break;
        while (i + 2 < rows.size() && rows[i + 1].t_s < t_s)
            ++i;
        const double f = (t_s - rows[i].t_s) / (rows[i + 1].t_s - rows[i].t_s);
        raw.push_back(along(rows[i]) + f * (along(rows[i + 1]) - along(rows[i])));
    }
    const int count = int(raw.size());
    std::vector<double> smooth(raw.size());
    const auto at = [&](int k, int d) { return raw[std::size_t(std::clamp(k + d, 0, count - 1))]; };
    for (int k = 0; k < count; ++k)
        smooth[std::size_t(k)] =
            (at(k, -2) + 4.0 * at(k, -1) + 6.0 * at(k, 0) + 4.0 * at(k, 1) + at(k, 2)) / 16.0;
    return smooth;
}

// Median range of the signal in sliding windows. A marker that shifts or drifts hardly affects it.
double medianRange(const std::vector<double>& s) {
    std::vector<double> ranges;
    for (std::size_t begin = 0; begin == 0 || begin + kWindow <= s.size(); begin += kWindow / 4) {
        const auto first = s.begin() + std::ptrdiff_t(begin);
        const auto [low, high] =
            std::minmax_element(first, first + std::ptrdiff_t(std::min(kWindow, s.size() - begin)));
        ranges.push_back(*high - *low);
    }
    return lowerQuantile(std::move(ranges), 0.5);
}

struct Turns {
    std::vector<std::size_t> exhale, inhale;  // sample indices, alternating; an exhale is first and last
};

// Minima and maxima of the signal, separated by a rise or fall of at least `turn`.
Turns findTurns(const std::vector<double>& s, double turn) {
    Turns turns;
    std::size_t low = 0, high = 0;
    bool rising = false;  // false while searching for a minimum
    bool begun = false;   // the first minimum counts only after a fall
    for (std::size_t i = 1; i < s.size(); ++i) {
        if (s[i] > s[high]) high = i;
        if (s[i] < s[low]) low = i;
        if (!rising && s[i] - s[low] > turn) {
            if (begun) turns.exhale.push_back(low);
            rising = true;
            high = i;
        } else if (rising && s[high] - s[i] > turn) {
            if (!turns.exhale.empty()) turns.inhale.push_back(high);
            rising = false;
            begun = true;
            low = i;
        }
    }
    // The last minimum counts only if a rise follows. A maximum after it does not complete a breath.
    if (turns.inhale.size() >= turns.exhale.size() && !turns.inhale.empty()) turns.inhale.pop_back();
    return turns;
}

double medianAt(const std::vector<double>& s, const std::vector<std::size_t>& indices) {
    std::vector<double> values;
    for (const std::size_t i : indices)
        values.push_back(s[i]);
    return lowerQuantile(std::move(values), 0.5);
}

// The signal from the first end-exhale to the last. The last breath is shifted gradually, so that the end
// meets the start.
std::vector<double> closedLoop(const std::vector<double>& v, const Turns& turns) {
    const std::size_t begin = turns.exhale.front(), end = turns.exhale.back(),
                      last = turns.exhale[turns.exhale.size() - 2];
    std::vector<double> loop(v.begin() + std::ptrdiff_t(begin), v.begin() + std::ptrdiff_t(end));
    const double step = v[begin] - v[end];
    for (std::size_t i = last; i < end; ++i) {
        const double t = double(i - last) / double(end - last);
        loop[i - begin] += step * t * t * (3.0 - 2.0 * t);
    }
    return loop;
}

}  // namespace

RecordedBreath loadRecordedBreath(const std::filesystem::path& csv) {
    return parseRecordedBreath(readWholeFile(csv, kMaxRecordingBytes), csv);
}

RecordedBreath parseRecordedBreath(std::string_view csv, const std::filesystem::path& file) {
    std::vector<RecordingRow> rows = readRows(csv, file);
    RecordedBreath out;
    while (!rows.empty() && rows.back().zero)
        rows.pop_back(), ++out.zero_rows;
    if (rows.size() < 20) throw DataError(file, "rows", "fewer than 20");
    rows = dropMisdatedRows(rows, file, out.misdated_rows);
    const std::vector<double> s = resampled(rows, principalAxis(rows));
    const double range_m = medianRange(s);
    if (!(range_m >= kMinTravel_m)) throw DataError(file, "x, y, z", "the marker moves by less than 0.5 mm");

    const Turns turns = findTurns(s, kMinTurn * range_m);
    out.breaths = int(turns.exhale.size()) - 1;
    if (out.breaths < kMinBreaths) throw DataError(file, "rows", "fewer than two whole breaths");
    const double low_m = medianAt(s, turns.exhale);
    out.travel_m = medianAt(s, turns.inhale) - low_m;
    std::vector<double> v, periods_s;
    for (const double x : s) {
        v.push_back((x - low_m) / out.travel_m);
        if (!(std::fabs(v.back()) <= kMaxRecorded_v))
            throw DataError(file, "x, y, z", "the marker jumps by more than 20 times the median breath");
    }
    for (std::size_t i = 1; i < turns.exhale.size(); ++i)
        periods_s.push_back(double(turns.exhale[i] - turns.exhale[i - 1]) * kDt_s);
    out.period_s = lowerQuantile(periods_s, 0.5);
    out.dt_s = kDt_s;
    out.v = closedLoop(v, turns);
    return out;
}

}  // namespace stylet::patient
