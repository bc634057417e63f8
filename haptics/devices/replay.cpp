#include "haptics/devices/replay.h"

#include <array>
#include <cmath>
#include <fstream>
#include <string>

#include "base/csv.h"
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

constexpr std::string_view kHeader = "t_ns,x_m,y_m,z_m,qw,qx,qy,qz,buttons";
constexpr std::size_t kMaxTraceBytes = std::size_t(1) << 29;
constexpr std::int64_t kMaxTime_ns = 86'400'000'000'000;  // a day
constexpr double kMaxPosition_m = 10.0;
constexpr double kUnitTolerance = 1e-3;

TraceSample readSample(CsvReader& rows) {
    TraceSample s;
    s.t_ns = rows.number<std::int64_t>(0, kMaxTime_ns);
    Pose& pose = s.device_from_stylus;
    for (int k = 0; k < 3; ++k)
        pose.position_m[k] = rows.number(-kMaxPosition_m, kMaxPosition_m);
    for (double* part : {&pose.rotation.w, &pose.rotation.x, &pose.rotation.y, &pose.rotation.z})
        *part = rows.number<double>();
    if (!(std::fabs(glm::dot(pose.rotation, pose.rotation) - 1.0) <= kUnitTolerance))
        rows.refuseRow("the rotation is not a unit quaternion");
    s.buttons = rows.number<std::uint32_t>();
    return s;
}

}  // namespace

Trace parseTrace(const std::filesystem::path& file, std::string_view csv) {
    CsvReader rows(file, csv, kHeader);
    Trace trace;
    while (rows.next()) {
        const TraceSample sample = readSample(rows);
        if (!trace.samples.empty() && sample.t_ns <= trace.samples.back().t_ns)
            rows.refuseRow("its time is not later than the previous row's");
        trace.samples.push_back(sample);
    }
    if (trace.samples.empty()) rows.refuseRow("no samples");
    return trace;
}

Trace loadTrace(const std::filesystem::path& csv) {
    return parseTrace(csv, readWholeFile(csv, kMaxTraceBytes));
}

void saveTrace(const Trace& trace, const std::filesystem::path& csv) {
    std::string text(kHeader);
    text += '\n';
    for (const TraceSample& s : trace.samples) {
        const Pose& pose = s.device_from_stylus;
        text += shortestText(s.t_ns);
        for (const double value : {pose.position_m.x, pose.position_m.y, pose.position_m.z, pose.rotation.w,
                                   pose.rotation.x, pose.rotation.y, pose.rotation.z})
            text += ',' + shortestText(value);
        text += ',' + shortestText(s.buttons) + '\n';
    }
    writeWholeFile(csv, text);
}

}  // namespace stylet::haptics
