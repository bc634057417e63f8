#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include <fmt/core.h>
#include <fmt/ranges.h>

#include "app/records/record.h"
#include "base/hex.h"
#include "patient/package/package.h"
#include "tests/bench/soak/soak.h"

namespace stylet::soak {

namespace {

// Growth in bytes that is not reported as a leak. With pictures, the heap may grow by kDriverSlack instead
// of kHeapSlack, because a graphics driver allocates on first use, which may be late in the soak.
constexpr double kHeapSlack = 64 << 10, kDriverSlack = 512 << 10, kResidentSlack = 16 << 20;
constexpr double kRegionSlack = 32.0, kLogSlack = 4096.0;  // memory regions; bytes of log
// Allowed heap growth per created headset, in bytes. For each headset, Debian's OpenXR loader (1.0.20) leaks
// 2.2 KB in about 120 allocations, and Mesa (22.3) leaks 0.3 KB.
constexpr double kHeadsetHeap = 3200.0;

}  // namespace

double Latency::quantile_us(double share) const {
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < bins_.size(); ++i) {
        below += bins_[i];
        if (double(below) >= share * double(count_)) return double(i + 1) / kBinsPerMicrosecond;
    }
    return max_us_;
}

std::vector<std::string> findFailures(const Result& r, const Settings& settings) {
    std::vector<std::string> bad = r.counts.implausible;
    const ResourceUse &then = r.resources[r.compared], &now = r.resources.back();
    const auto grew = [&](const char* what, double from, double to, double slack) {
        if (to <= from + slack) return;
        bad.push_back(fmt::format("{} grew from {:.0f} to {:.0f}", what, from, to));
    };
    const double lost_bytes = kHeadsetHeap * double(now.headsets - then.headsets);
    grew("the heap in use", double(then.heap_bytes), double(now.heap_bytes),
         lost_bytes + (settings.pictures ? kDriverSlack : kHeapSlack));
    grew("resident memory", double(then.resident_bytes), double(now.resident_bytes),
         lost_bytes + kResidentSlack);
    grew("open descriptors", then.descriptors, now.descriptors, 0.0);
    grew("threads", then.threads, now.threads, 0.0);
    grew("mapped regions", then.regions, now.regions, kRegionSlack);
    for (const double share : {0.5, 0.9, 0.99})
        if (r.last.quantile_us(share) > settings.max_slowdown * r.first.quantile_us(share) + 0.1)
            bad.push_back(fmt::format("a tick at the {:.0f} % quantile took {:.2f} us, now {:.2f} us",
                                      100.0 * share, r.first.quantile_us(share), r.last.quantile_us(share)));
    grew("what the same rounds write into the log",
         double(r.resources[r.compared].logged_bytes - r.resources[0].logged_bytes),
         double(now.logged_bytes - r.resources[r.rounds - 1 - r.compared].logged_bytes), kLogSlack);
    for (std::size_t i = 0; i < r.compared; ++i)
        if (r.hashes[1 + i] != r.hashes[r.rounds - r.compared + i])
            bad.push_back("round " + std::to_string(2 + i) + " made again ends in another hash");
    const Counts& c = r.counts;
    const auto needed = [&](const char* what, bool there) {
        if (!there) bad.push_back(std::string("nothing was soaked: no ") + what);
    };
    needed("hit", c.hits > 0), needed("wrong puncture", c.wrong_cuts > 0), needed("hold", c.holds > 0);
    needed("incision", c.incisions > 0), needed("needle in the guide", c.guided > 0);
    needed("fault", c.faults > 0), needed("re-arming", c.rearmed > 0), needed("X-ray pulse", c.pulses > 0);
    needed("contrast medium", c.contrast_ml > 0.0), needed("bookmark", c.bookmarks > 0);
    needed("alert", c.alerts > 0), needed("hint", c.hints > 0), needed("replayed record", c.replayed > 0);
    needed("stored attempt", c.stored == c.attempts), needed("sound", c.sounds > 0);
    needed("attempt from a bookmark", c.retries > 0);
    if (settings.pictures) needed("frame", c.frames > 0), needed("machine picture", c.pictures > 0);
    if (settings.pictures) needed("headset lost and found", c.headsets > r.rounds);
    if (!settings.centre.empty()) needed("attempt at the training centre", c.sent > 0);
    if (!settings.breath.empty()) needed("recorded breath that began anew", c.recordings >= r.rounds);
    // A fault may cut the drainage short before its last tool.
    for (std::size_t tool = 0; tool <= std::size_t(haptics::Tool::needle); ++tool)
        needed(std::string(haptics::kToolNames[tool]).c_str(), c.tools[tool] > 0);
    return bad;
}

std::string formatReport(const Result& r) {
    const Counts& c = r.counts;
    const ResourceUse &then = r.resources[r.compared], &now = r.resources.back();
    std::string report;
    const auto line = [&]<typename... T>(fmt::format_string<T...> format, T&&... values) {
        report += fmt::format(format, std::forward<T>(values)...);
    };
    line("soak: {} ticks, {} attempts in {} rounds, {:.0f} s: {:.2f} us a tick with everything\n", c.ticks,
         c.attempts, r.rounds, r.seconds, 1e6 * r.seconds / double(c.ticks));
    line("  done       {} hits, {} cuts, {} of structures at risk, {} holds, {} incisions,\n", c.hits, c.cuts,
         c.wrong_cuts, c.holds, c.incisions);
    line("             {} ticks in the guide, {} faults, {} starts of the force, {} commands,\n", c.guided,
         c.faults, c.rearmed, c.commands);
    line("             {} X-ray pulses, {:.0f} ml of contrast medium, {} bookmarks, {} hint panels,\n",
         c.pulses, c.contrast_ml, c.bookmarks, c.hints);
    line("             {} alerts, {} sounds, {} frames in {} headsets, {} machine pictures,\n", c.alerts,
         c.sounds, c.frames, c.headsets, c.pictures);
    line("             {} attempts begun from a bookmark, {} rounds of the recorded breath,\n", c.retries,
         c.recordings);
    line("             {} sent to the training centre, {} while it was away, {} lines said,\n", c.sent,
         c.unsent, c.logged);
    line("             {} records replayed, {} attempts stored\n", c.replayed, c.stored);
    line("             ticks with finger, probe, scalpel, guide, needle, wire, dilator, drain in hand: {}\n",
         fmt::join(c.tools, ", "));
    line("  held       after round {} -> at the end\n", r.compared + 1);
    line("    heap     {:.3f} -> {:.3f} MB\n", 1e-6 * double(then.heap_bytes), 1e-6 * double(now.heap_bytes));
    line("    resident {:.1f} -> {:.1f} MB\n", 1e-6 * double(then.resident_bytes),
         1e-6 * double(now.resident_bytes));
    line("    handles  {} -> {}\n    threads  {} -> {}\n    regions  {} -> {}\n", then.descriptors,
         now.descriptors, then.threads, now.threads, then.regions, now.regions);
    line("  a tick     the same {} rounds at the beginning -> at the end [us of the processor]\n",
         r.compared);
    for (const double share : {0.5, 0.9, 0.99, 0.999})
        line("    {:<4.5g} % {:.2f} -> {:.2f}\n", 100.0 * share, r.first.quantile_us(share),
             r.last.quantile_us(share));
    line("    longest  {:.0f} -> {:.0f}\n", r.first.max_us(), r.last.max_us());
    line("  state hash {:016x}\n", r.state_hash);
    return report;
}

void writeJson(const Result& r, const Settings& settings, const std::filesystem::path& file) {
    nlohmann::ordered_json resources = nlohmann::json::array();
    for (const ResourceUse& h : r.resources)
        resources.push_back({h.heap_bytes, h.resident_bytes, h.descriptors, h.threads, h.regions, h.headsets,
                             h.logged_bytes});
    const auto times = [](const Latency& l) {
        return nlohmann::ordered_json{{"p50", l.quantile_us(0.5)},
                                      {"p90", l.quantile_us(0.9)},
                                      {"p99", l.quantile_us(0.99)},
                                      {"p999", l.quantile_us(0.999)},
                                      {"longest", l.max_us()}};
    };
    const nlohmann::ordered_json json{
        {"seed", settings.seed},
        {"ticks", r.counts.ticks},
        {"attempts", r.counts.attempts},
        {"headsets", r.counts.headsets},
        {"frames", r.counts.frames},
        {"retries", r.counts.retries},
        {"sent", r.counts.sent},
        {"sounds", r.counts.sounds},
        {"seconds", r.seconds},
        {"tick_us_first", times(r.first)},
        {"tick_us_last", times(r.last)},
        {"state_hash", hexText(r.state_hash)},
        {"complaints", findFailures(r, settings)},
        {"held_fields",
         {"heap_bytes", "resident_bytes", "descriptors", "threads", "regions", "headsets", "logged_bytes"}},
        {"held_after_each_round", resources}};
    std::ofstream out(file);
    out << json.dump(1) << '\n';
    if (!out) throw DataError(file, "file", "cannot be written");
}

}  // namespace stylet::soak
