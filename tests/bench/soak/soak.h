// The soak: runs attempts one after the other in one process on the trainer's own virtual clock. Each is
// assembled as `stylet run --fast --trainee` does. Afterwards memory, handles, threads and the time of a tick
// must be unchanged. The first attempts, repeated at the end, must give the same hashes.
//
// A round runs every scenario once. Every attempt has sounds on a silent device, hints, alerts, score,
// record, store, force truth, faults and instructor commands. Three features are used once per round, each in
// a scenario that changes from round to round. First, the room is drawn in the mock runtime's headset, with
// 96 x 96 pixels per eye and a frame every two virtual seconds; the view is recentred, and the session is
// lost and restored. Second, an attempt is retried from a bookmark. Third, result files are written and the
// record is replayed. If there is a training centre, all attempts are sent to it and deleted there; once per
// round it does not answer. 1e8 ticks take about 35 minutes on one core.
//
// Left out, because they need the wall clock or a person: the threads of a real-time attempt, devices,
// controllers, the instructor's window and console, `--show`. Other tests cover them in real time.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "haptics/tools/tool.h"

namespace stylet::soak {

// A fault injected into the soak itself, to check that it is found. Each attempt adds to it.
enum class Leak : std::uint8_t { none, memory, descriptor, thread, region, time, state };

struct Settings {
    std::uint64_t ticks = 1'000'000;  // minimum: rounds are always completed
    std::uint64_t seed = 1;
    double spacing_m = 0.003;      // of the reference patient
    std::size_t scenarios = 100;   // maximum number per round, from the first
    std::filesystem::path folder;  // folder of the store; emptied after each attempt
    bool pictures = false;         // the room in a headset and the equipment's screens; needs Vulkan, xrmock
    double fps = 0.5;              // frames per virtual second
    std::string centre;            // PostgreSQL of a training centre; empty: nothing is sent
    std::filesystem::path breath;  // recorded marker track, repeated beyond its end; empty: none
    double max_slowdown = 1.5;     // limit of last over first tick times, at the median, 90 and 99 %
    std::chrono::milliseconds timeout{20'000};  // wait for threads that are about to end
    Leak leak = Leak::none;
    std::function<void(const std::string&)> log = [](const std::string&) {};
};

// Resources of the process between two attempts.
struct ResourceUse {
    std::uint64_t heap_bytes = 0;  // in use, according to the allocator
    std::uint64_t resident_bytes = 0;
    int descriptors = 0, threads = 0, regions = 0;  // regions: mapped memory regions
    std::uint64_t headsets = 0;                     // created so far
    std::uint64_t logged_bytes = 0;                 // written to stderr so far, if it is a file
};
// process_linux.cpp
// Call first. Otherwise the peak size of each thread's arena stays resident and hides growth.
void limitHeapArenas();
ResourceUse measureResources(int threads,
                             std::chrono::milliseconds timeout);  // waits until at most `threads` run
void leakRegions();                                               // leaks some memory regions
int leakDescriptor();                                             // leaks a descriptor
double threadTime_us();                                           // CPU time of the calling thread

// Times of ticks, each with all its processing: device, force, session, score, record.
class Latency {
  public:
    void add(double us) noexcept {
        const auto bin = std::size_t(us * kBinsPerMicrosecond);
        ++bins_[bin < bins_.size() ? bin : bins_.size() - 1];
        ++count_;
        max_us_ = us > max_us_ ? us : max_us_;
    }
    double quantile_us(double share) const;
    double max_us() const { return max_us_; }

  private:
    static constexpr double kBinsPerMicrosecond = 50.0;
    std::array<std::uint32_t, 50'000> bins_{};  // up to 1 ms
    std::uint64_t count_ = 0;
    double max_us_ = 0.0;
};

// Counts of what happened, to check that the soak exercised everything.
struct Counts {
    std::uint64_t attempts = 0, ticks = 0, hits = 0, cuts = 0, wrong_cuts = 0, holds = 0, incisions = 0,
                  guided = 0, faults = 0, rearmed = 0, commands = 0, pulses = 0, bookmarks = 0, hints = 0,
                  alerts = 0, pictures = 0, frames = 0, headsets = 0, sounds = 0, retries = 0, sent = 0,
                  unsent = 0, recordings = 0, logged = 0, replayed = 0, stored = 0;
    std::array<std::uint64_t, haptics::kToolCount> tools{};  // ticks per tool
    double contrast_ml = 0.0;
    std::vector<std::string> implausible;  // impossible results
};

struct Result {
    Counts counts;
    std::size_t rounds = 0, compared = 0;  // the last `compared` rounds repeat early ones
    std::vector<ResourceUse> resources;    // after each round
    std::vector<std::uint64_t> hashes;     // one per round
    Latency first, last;                   // of the compared rounds
    double seconds = 0.0;
    std::uint64_t state_hash = 0;  // over all rounds
};
// Throws DataError.
Result soak(const Settings&);

// Returns the failed checks; empty if all passed.
std::vector<std::string> findFailures(const Result&, const Settings&);
std::string formatReport(const Result&);
void writeJson(const Result&, const Settings&, const std::filesystem::path& file);

}  // namespace stylet::soak
