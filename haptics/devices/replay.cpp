#include "haptics/devices/replay.h"

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string>

#include "base/line_reader.h"
#include "base/whole_file.h"
#include "patient/patient.h"

namespace stylet::haptics {

ReplayDevice::ReplayDevice(const Trace& trace, std::int64_t start_ns, const DeviceProfile& profile)
    : trace_(&trace), start_ns_(start_ns), profile_(profile) {}

DeviceState ReplayDevice::read(std::int64_t now_ns) noexcept {
    const TraceSample sample = sampleAt(*trace_, now_ns - start_ns_, cursor_);
    return {.device_from_stylus = sample.device_from_stylus, .buttons = sample.buttons};
}

namespace {

constexpr std::string_view kHead = "t_ns,x_m,y_m,z_m,qw,qx,qy,qz,buttons";
constexpr std::size_t kMaxTraceBytes = std::size_t(1) << 29;
constexpr std::int64_t kLongest_ns = 86'400'000'000'000;  // a day
constexpr double kFarthestSample_m = 10.0;
constexpr double kUnitTolerance = 1e-3;

class TraceReader {
  public:
    TraceReader(const std::filesystem::path& file, std::string_view text) : lines_(file, text) {}

    Trace trace() {
        if (lines_.next() != kHead) lines_.refuse("the columns are not " + std::string(kHead));
        Trace trace;
        std::int64_t last_ns = -1;
        while (!lines_.done()) {
            line_text_ = lines_.next();
            trace.samples.push_back(sample());
            if (trace.samples.back().t_ns <= last_ns) lines_.refuse("the time does not grow");
            last_ns = trace.samples.back().t_ns;
        }
        if (trace.samples.empty()) lines_.refuse("no samples");
        return trace;
    }

  private:
    // Parses the next field of the line. Nothing may follow the `last` one.
    template <typename Number>
    Number number(bool last = false) {
        Number value{};
        const char* const end = line_text_.data() + line_text_.size();
        const auto [stop, error] = std::from_chars(line_text_.data(), end, value);
        const bool whole = last ? stop == end : stop != end && *stop == ',';
        if (error != std::errc() || !whole) lines_.refuse("not nine numbers in range");
        line_text_ = last ? std::string_view() : line_text_.substr(std::size_t(stop + 1 - line_text_.data()));
        return value;
    }
    TraceSample sample() {
        TraceSample s;
        s.t_ns = number<std::int64_t>();
        if (s.t_ns < 0 || s.t_ns > kLongest_ns) lines_.refuse("a time outside one day");
        Pose& pose = s.device_from_stylus;
        for (int k = 0; k < 3; ++k) {
            pose.position_m[k] = number<double>();
            if (!(std::fabs(pose.position_m[k]) <= kFarthestSample_m))
                lines_.refuse("a place farther than 10 m");
        }
        pose.rotation.w = number<double>();
        pose.rotation.x = number<double>();
        pose.rotation.y = number<double>();
        pose.rotation.z = number<double>();
        if (!(std::fabs(glm::dot(pose.rotation, pose.rotation) - 1.0) <= kUnitTolerance))
            lines_.refuse("the rotation is not a unit quaternion");
        s.buttons = number<std::uint32_t>(true);
        return s;
    }

    LineReader lines_;
    std::string_view line_text_;
};

template <typename Number>
void append(std::string& line, Number value, char after) {
    std::array<char, 40> text;
    const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
    line.append(text.data(), error == std::errc() ? end : text.data());
    line += after;
}

}  // namespace

Trace parseTrace(const std::filesystem::path& file, std::string_view csv) {
    return TraceReader(file, csv).trace();
}

Trace loadTrace(const std::filesystem::path& csv) {
    return parseTrace(csv, readWholeFile(csv, kMaxTraceBytes));
}

void saveTrace(const Trace& trace, const std::filesystem::path& csv) {
    const std::filesystem::path fresh = csv.string() + ".new";
    std::ofstream out(fresh, std::ios::binary);
    out << kHead << '\n';
    for (const TraceSample& s : trace.samples) {
        const Pose& pose = s.device_from_stylus;
        std::string line;
        append(line, s.t_ns, ',');
        for (int k = 0; k < 3; ++k)
            append(line, pose.position_m[k], ',');
        for (const double q : {pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z})
            append(line, q, ',');
        append(line, s.buttons, '\n');
        out << line;
    }
    out.close();
    if (!out) throw DataError(fresh, "file", "cannot be written");
    std::filesystem::rename(fresh, csv);
}

}  // namespace stylet::haptics
