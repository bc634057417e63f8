#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

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
// Allowed heap growth per created headset, in bytes. For each headset, Debian's OpenXR loader (1.0.20) does
// not free 2.2 KB in about 120 allocations, and Mesa (22.3) does not free 0.3 KB.
constexpr double kHeadsetHeap = 3200.0;

}  // namespace

double Latency::quantile_us(double share) const {
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < bins_.size(); ++i) {
        below += bins_[i];
        if (double(below) >= share * double(count_)) return double(i + 1) / kBinsAMicrosecond;
    }
    return most_us_;
}

std::vector<std::string> complaintsOf(const Result& r, const Settings& settings) {
    std::vector<std::string> bad = r.counts.insane;
    const Held &then = r.held[r.compared], &now = r.held.back();
    const auto grew = [&](const char* what, double from, double to, double slack) {
        if (to <= from + slack) return;
        char line[160];
        std::snprintf(line, sizeof line, "%s grew from %.0f to %.0f", what, from, to);
        bad.emplace_back(line);
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
        if (r.last.quantile_us(share) > settings.most_slower * r.first.quantile_us(share) + 0.1) {
            char line[160];
            std::snprintf(line, sizeof line, "a tick at the %.0f %% quantile took %.2f us, now %.2f us",
                          100.0 * share, r.first.quantile_us(share), r.last.quantile_us(share));
            bad.emplace_back(line);
        }
    grew("what the same rounds write into the log",
         double(r.held[r.compared].logged_bytes - r.held[0].logged_bytes),
         double(now.logged_bytes - r.held[r.rounds - 1 - r.compared].logged_bytes), kLogSlack);
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
    needed("five tools", std::find(c.tools.begin(), c.tools.end(), 0u) == c.tools.end());
    return bad;
}

std::string reportOf(const Result& r) {
    const Counts& c = r.counts;
    const Held &then = r.held[r.compared], &now = r.held.back();
    std::string report;
    const auto line = [&](const char* format, const auto&... values) {
        char text[400];
        std::snprintf(text, sizeof text, format, values...);
        report += text;
    };
    const auto n = [](std::uint64_t count) { return static_cast<unsigned long long>(count); };
    line("soak: %llu ticks, %llu attempts in %zu rounds, %.0f s: %.2f us a tick with everything\n",
         n(c.ticks), n(c.attempts), r.rounds, r.seconds, 1e6 * r.seconds / double(c.ticks));
    line("  done       %llu hits, %llu cuts, %llu of structures at risk, %llu holds, %llu incisions,\n",
         n(c.hits), n(c.cuts), n(c.wrong_cuts), n(c.holds), n(c.incisions));
    line("             %llu ticks in the guide, %llu faults, %llu starts of the force, %llu commands,\n",
         n(c.guided), n(c.faults), n(c.rearmed), n(c.commands));
    line("             %llu X-ray pulses, %.0f ml of contrast medium, %llu bookmarks, %llu hint panels,\n",
         n(c.pulses), c.contrast_ml, n(c.bookmarks), n(c.hints));
    line("             %llu alerts, %llu sounds, %llu frames in %llu headsets, %llu machine pictures,\n",
         n(c.alerts), n(c.sounds), n(c.frames), n(c.headsets), n(c.pictures));
    line("             %llu attempts begun from a bookmark, %llu rounds of the recorded breath,\n",
         n(c.retries), n(c.recordings));
    line("             %llu sent to the training centre, %llu while it was away, %llu lines said,\n",
         n(c.sent), n(c.unsent), n(c.said));
    line("             %llu records replayed, %llu attempts stored\n", n(c.replayed), n(c.stored));
    line(
        "             ticks with finger, probe, scalpel, guide, needle in hand: %llu, %llu, %llu, %llu, "
        "%llu\n",
        n(c.tools[0]), n(c.tools[1]), n(c.tools[2]), n(c.tools[3]), n(c.tools[4]));
    line("  held       after round %zu -> at the end\n", r.compared + 1);
    line("    heap     %.3f -> %.3f MB\n", 1e-6 * double(then.heap_bytes), 1e-6 * double(now.heap_bytes));
    line("    resident %.1f -> %.1f MB\n", 1e-6 * double(then.resident_bytes),
         1e-6 * double(now.resident_bytes));
    line("    handles  %d -> %d\n    threads  %d -> %d\n    regions  %d -> %d\n", then.descriptors,
         now.descriptors, then.threads, now.threads, then.regions, now.regions);
    line("  a tick     the same %zu rounds at the beginning -> at the end [us of the processor]\n",
         r.compared);
    for (const double share : {0.5, 0.9, 0.99, 0.999})
        line("    %-4.5g %% %.2f -> %.2f\n", 100.0 * share, r.first.quantile_us(share),
             r.last.quantile_us(share));
    line("    longest  %.0f -> %.0f\n", r.first.most_us(), r.last.most_us());
    line("  state hash %016llx\n", n(r.state_hash));
    return report;
}

void writeJson(const Result& r, const Settings& settings, const std::filesystem::path& file) {
    nlohmann::ordered_json held = nlohmann::json::array();
    for (const Held& h : r.held)
        held.push_back({h.heap_bytes, h.resident_bytes, h.descriptors, h.threads, h.regions, h.headsets,
                        h.logged_bytes});
    const auto times = [](const Latency& l) {
        return nlohmann::ordered_json{{"p50", l.quantile_us(0.5)},
                                      {"p90", l.quantile_us(0.9)},
                                      {"p99", l.quantile_us(0.99)},
                                      {"p999", l.quantile_us(0.999)},
                                      {"longest", l.most_us()}};
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
        {"complaints", complaintsOf(r, settings)},
        {"held_fields",
         {"heap_bytes", "resident_bytes", "descriptors", "threads", "regions", "headsets", "logged_bytes"}},
        {"held_after_each_round", held}};
    std::ofstream out(file);
    out << json.dump(1) << '\n';
    if (!out) throw DataError(file, "file", "cannot be written");
}

}  // namespace stylet::soak
