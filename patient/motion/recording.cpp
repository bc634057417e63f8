// Computes the surrogate from a marker's track: its first principal axis, scaled by the median breath. The
// result is hashed: no libm transcendentals.
#include "patient/motion/recording.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>

#include "base/errors.h"
#include "base/geometry.h"
#include "base/line_reader.h"
#include "base/statistics.h"
#include "base/whole_file.h"

namespace stylet::patient {
namespace {

constexpr std::size_t kMaxRecordingBytes = 16 << 20;
constexpr std::size_t kMaxRows = 200'000;
constexpr double kLongest_s = 3600.0, kFarthestMarker_m = 10.0;
constexpr double kDt_s = 0.1;
constexpr double kWidestGap_s = 0.5;       // largest gap between accepted rows
constexpr double kMisdatedShare = 0.02;    // maximum share of misdated rows
constexpr double kLeastTravel_m = 0.0005;  // anything less is camera noise
constexpr double kMost_v = 20.0;           // deeper than any sigh
constexpr int kFewestBreaths = 2;
constexpr double kTurn = 0.35;       // share of the usual range by which a breath must rise and fall
constexpr std::size_t kWindow = 80;  // samples; long enough to contain a whole breath

struct RecordingRow {
    double t_s = 0.0;
    Vec3 p_m{0.0};
    bool zero = false;
};

// One line with fields separated by semicolons.
class Line {
  public:
    explicit Line(std::string_view text) : rest_(text) {}
    bool done() const { return ended_; }
    std::string_view field() {
        const std::size_t end = rest_.find(';');
        const std::string_view field = rest_.substr(0, end);
        ended_ = end == std::string_view::npos;
        rest_ = ended_ ? std::string_view() : rest_.substr(end + 1);
        return field;
    }

  private:
    std::string_view rest_;
    bool ended_ = false;
};

std::optional<double> number(std::string_view text) {
    std::array<char, 40> copy;
    if (text.empty() || text.size() > copy.size()) return std::nullopt;
    std::copy(text.begin(), text.end(), copy.begin());
    std::replace(copy.begin(), copy.begin() + std::ptrdiff_t(text.size()), ',', '.');
    double value = 0.0;
    const char* const end = copy.data() + text.size();
    const auto [stop, error] = std::from_chars(copy.data(), end, value);
    if (error != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
    return value;
}

class Reader {
  public:
    Reader(std::string_view text, const std::filesystem::path& file) : lines_(file, text) {}

    std::vector<RecordingRow> rows() {
        checkHead();
        std::vector<RecordingRow> rows;
        while (!lines_.done()) {
            const std::string_view line = lines_.next();
            if (line.empty() && lines_.done()) break;
            if (rows.size() == kMaxRows) lines_.refuse("more than " + std::to_string(kMaxRows) + " rows");
            rows.push_back(row(line));
        }
        return rows;
    }

  private:
    void checkHead() {
        Line line(lines_.next());
        for (const std::string_view name : {"Frame", "Timestamp", "x", "y", "z"}) {
            std::string_view field = line.done() ? std::string_view() : line.field();
            if (field.size() >= 2 && field.front() == '"' && field.back() == '"')
                field = field.substr(1, field.size() - 2);
            if (field != name) lines_.refuse("the columns are not Frame;Timestamp;x;y;z");
        }
        if (!line.done()) lines_.refuse("more columns than Frame;Timestamp;x;y;z");
    }
    RecordingRow row(std::string_view text) const {
        Line line(text);
        std::array<double, 5> values{};
        for (double& value : values) {
            const auto read = line.done() ? std::nullopt : number(line.field());
            if (!read) lines_.refuse("not five numbers");
            value = *read;
        }
        if (!line.done()) lines_.refuse("more than five numbers");
        RecordingRow row{values[1] * 1e-3, Vec3(values[2], values[3], values[4]) * 1e-3, false};
        for (int k = 0; k < 3; ++k)
            if (!(std::fabs(row.p_m[k]) <= kFarthestMarker_m)) lines_.refuse("a marker farther than 10 m");
        if (!(row.t_s >= 0.0 && row.t_s <= kLongest_s)) lines_.refuse("a time outside one hour");
        row.zero = std::all_of(values.begin(), values.end(), [](double v) { return v == 0.0; });
        return row;
    }

    LineReader lines_;
};

// Keeps rows in time order. Drops a row whose time is before its predecessor's or far ahead of it.
std::vector<RecordingRow> inOrder(const std::vector<RecordingRow>& rows, const std::filesystem::path& file,
                                  int& misdated) {
    std::vector<RecordingRow> kept{rows.front()};
    for (std::size_t i = 0; i < rows.size(); ++i) {
        if (rows[i].zero) throw DataError(file, "line " + std::to_string(i + 2), "a row of zeros inside");
        if (i == 0) continue;
        const double gap_s = rows[i].t_s - kept.back().t_s;
        if (gap_s > 0.0 && gap_s <= kWidestGap_s)
            kept.push_back(rows[i]);
        else
            ++misdated;
    }
    if (double(misdated) > kMisdatedShare * double(rows.size()))
        throw DataError(file, "Timestamp",
                        std::to_string(misdated) + " of " + std::to_string(rows.size()) +
                            " rows break the order of time or leave a gap above 0.5 s");
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
        const double length = std::sqrt(axis.x * axis.x + axis.y * axis.y + axis.z * axis.z);
        if (!(length > 0.0)) return {0.0, 0.0, 1.0};
        axis = covariance * (axis / length);
    }
    const double length = std::sqrt(axis.x * axis.x + axis.y * axis.y + axis.z * axis.z);
    return axis / (axis.z < 0.0 ? -length : length);
}

// Position along `axis` every kDt_s, smoothed to remove the camera's quantisation (binomial over five
// samples: loses 2 % at 0.3 Hz).
std::vector<double> resampled(const std::vector<RecordingRow>& rows, const Vec3& axis) {
    const auto along = [&](const RecordingRow& r) {
        const Vec3 d = r.p_m - rows.front().p_m;
        return d.x * axis.x + d.y * axis.y + d.z * axis.z;
    };
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
    std::vector<double> smooth(raw.size());
    const auto at = [&](std::size_t k, int d) {
        return raw[std::size_t(
            std::clamp(std::ptrdiff_t(k) + d, std::ptrdiff_t(0), std::ptrdiff_t(raw.size()) - 1))];
    };
    for (std::size_t k = 0; k < raw.size(); ++k)
        smooth[k] = (at(k, -2) + 4.0 * at(k, -1) + 6.0 * at(k, 0) + 4.0 * at(k, 1) + at(k, 2)) / 16.0;
    return smooth;
}

// Median range of the signal over sliding windows. Not affected by a marker that shifts or drifts.
double usualRange(const std::vector<double>& s) {
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
Turns turnsOf(const std::vector<double>& s, double turn) {
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

double medianAt(const std::vector<double>& s, const std::vector<std::size_t>& where) {
    std::vector<double> values;
    for (const std::size_t i : where)
        values.push_back(s[i]);
    return lowerQuantile(std::move(values), 0.5);
}

// From the first end-exhale to the last. During the last breath the level blends to that of the start.
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
    std::vector<RecordingRow> rows = Reader(csv, file).rows();
    RecordedBreath out;
    while (!rows.empty() && rows.back().zero)
        rows.pop_back(), ++out.zero_rows;
    if (rows.size() < 20) throw DataError(file, "rows", "fewer than 20");
    rows = inOrder(rows, file, out.misdated_rows);
    const std::vector<double> s = resampled(rows, principalAxis(rows));
    const double range_m = usualRange(s);
    if (!(range_m >= kLeastTravel_m))
        throw DataError(file, "x, y, z", "the marker moves by less than 0.5 mm");

    const Turns turns = turnsOf(s, kTurn * range_m);
    out.breaths = int(turns.exhale.size()) - 1;
    if (out.breaths < kFewestBreaths) throw DataError(file, "rows", "fewer than two whole breaths");
    const double low_m = medianAt(s, turns.exhale);
    out.travel_m = medianAt(s, turns.inhale) - low_m;
    std::vector<double> v, periods_s;
    for (const double x : s) {
        v.push_back((x - low_m) / out.travel_m);
        if (!(std::fabs(v.back()) <= kMost_v))
            throw DataError(file, "x, y, z", "the marker leaps: farther than twenty breaths are deep");
    }
    for (std::size_t i = 1; i < turns.exhale.size(); ++i)
        periods_s.push_back(double(turns.exhale[i] - turns.exhale[i - 1]) * kDt_s);
    out.period_s = lowerQuantile(periods_s, 0.5);
    out.dt_s = kDt_s;
    out.v = closedLoop(v, turns);
    return out;
}

}  // namespace stylet::patient
