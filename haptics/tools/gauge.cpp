#include "haptics/tools/gauge.h"

#include <algorithm>

#include "base/fields.h"
#include "base/whole_file.h"

namespace stylet::haptics {

namespace {

constexpr std::size_t kMaxGauges = 64, kMaxGaugeBytes = 1 << 16;

const NeedleGauge* findGauge(const std::vector<NeedleGauge>& all, int gauge) {
    const auto found = std::ranges::find(all, gauge, &NeedleGauge::gauge);
    return found == all.end() ? nullptr : &*found;
}

}  // namespace

std::vector<NeedleGauge> parseGauges(const std::filesystem::path& file, std::string_view toml) {
    Fields root = parseToml(file, toml);
    std::vector<NeedleGauge> all;
    for (Fields& needle : root.children("needle", kMaxGauges)) {
        const NeedleGauge one{int(needle.integer("gauge", 7, 34)), needle.number("outer_mm", 0.1, 5.0) / 1e3};
        if (findGauge(all, one.gauge)) needle.refuse("gauge", "twice");
        needle.finish();
        all.push_back(one);
    }
    root.finish();
    return all;
}

NeedleGauge loadGauge(const std::filesystem::path& toml, int gauge) {
    const std::vector<NeedleGauge> all = parseGauges(toml, readWholeFile(toml, kMaxGaugeBytes));
    if (const NeedleGauge* found = findGauge(all, gauge)) return *found;
    std::string gauges;
    for (const NeedleGauge& one : all)
        gauges += (gauges.empty() ? "" : ", ") + std::to_string(one.gauge);
    throw DataError(toml, "gauge " + std::to_string(gauge), "not among: " + gauges);
}

}  // namespace stylet::haptics
