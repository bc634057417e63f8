// The soak: attempts one after the other in one process, on the trainer's own virtual clock, each put
// together as `stylet run --fast --trainee` does. Afterwards the process must be what it was: memory,
// handles, threads, the time of a tick; and the attempts of the beginning, made again at the end, must end in
// the same hashes.
//
// A round is every scenario once. On in all of it: sounds to a device that nobody hears, hints, alerts,
// score, record, store, force truth, faults, an instructor's commands. Once a round, of another scenario each
// time: the room in the mock runtime's headset, a frame every two virtual seconds of 96 x 96 pixels an eye,
// recentred, lost and found again; an attempt again from a bookmark; the results' files and the record
// replayed. Where there is a training centre, all attempts are sent to it and deleted there; once a round it
// does not answer. So 1e8 ticks take a core some 35 minutes.
//
// Not on, as it has the clock on the wall or a person: the threads of an attempt in real time, devices,
// controllers, the instructor's window and console, `--show`. Tests in real time have them.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace stylet::soak {

// A fault put into the soak itself, to see that it would be found. Each attempt adds to it.
enum class Leak : std::uint8_t { none, memory, descriptor, thread, region, time, state };

struct Settings {
    std::uint64_t ticks = 1'000'000;  // at least: rounds are whole
    std::uint64_t seed = 1;
    double spacing_m = 0.003;      // of the reference patient
    std::size_t scenarios = 100;   // of a round, from the first; all at most
    std::filesystem::path folder;  // of the store; emptied attempt by attempt
    bool pictures = false;         // the room in a headset, and the machines' screens: needs Vulkan, xrmock
    double fps = 0.5;              // of them, a virtual second
    std::string centre;            // PostgreSQL of a training centre; empty: nothing is sent
    std::filesystem::path breath;  // a marker's track, breathed for longer than it is; empty: none
    double most_slower = 1.5;      // the last ticks against the first, at the median, 90 and 99 %
    std::chrono::milliseconds patience{20'000};  // for a thread that has said its last, and is on its way out
    Leak leak = Leak::none;
    std::function<void(const std::string&)> say = [](const std::string&) {};
};

// What the process holds between two attempts.
struct Held {
    std::uint64_t heap_bytes = 0;  // in use, by the allocator
    std::uint64_t resident_bytes = 0;
    int descriptors = 0, threads = 0, regions = 0;  // the last: of memory that are mapped
    std::uint64_t headsets = 0;                     // made so far
    std::uint64_t logged_bytes = 0;                 // on stderr so far, where that is a file
};
// process_linux.cpp
// First of all: else the most that each thread's arena ever had stays resident, and hides what grows.
void steadyHeap();
Held heldNow(int threads, std::chrono::milliseconds patience);  // waits until no more than those run
void mapNothing();                                              // some regions that nobody unmaps
int openNothing();                                              // a descriptor that nobody closes
double threadTime_us();                                         // of the processor, by the calling thread

// Times of ticks, each with all that comes of it: device, force, session, score, record.
class Latency {
  public:
    void add(double us) noexcept {
        const auto bin = std::size_t(us * kBinsAMicrosecond);
        ++bins_[bin < bins_.size() ? bin : bins_.size() - 1];
        ++count_;
        most_us_ = us > most_us_ ? us : most_us_;
    }
    double quantile_us(double share) const;
    double most_us() const { return most_us_; }

  private:
    static constexpr double kBinsAMicrosecond = 50.0;
    std::array<std::uint32_t, 50'000> bins_{};  // up to a millisecond
    std::uint64_t count_ = 0;
    double most_us_ = 0.0;
};

// What was done, so that nobody takes a soak of nothing for one.
struct Counts {
    std::uint64_t attempts = 0, ticks = 0, hits = 0, cuts = 0, wrong_cuts = 0, holds = 0, incisions = 0,
                  guided = 0, faults = 0, rearmed = 0, commands = 0, pulses = 0, bookmarks = 0, hints = 0,
                  alerts = 0, pictures = 0, frames = 0, headsets = 0, sounds = 0, retries = 0, sent = 0,
                  unsent = 0, recordings = 0, said = 0, replayed = 0, stored = 0;
    std::array<std::uint64_t, 5> tools{};  // ticks with each in hand
    double contrast_ml = 0.0;
    std::vector<std::string> insane;  // results that cannot be
};

struct Result {
    Counts counts;
    std::size_t rounds = 0, compared = 0;  // of the latter the first and the last are the same attempts
    std::vector<Held> held;                // after each round
    std::vector<std::uint64_t> hashes;     // of each round
    Latency first, last;                   // of the compared rounds
    double seconds = 0.0;
    std::uint64_t state_hash = 0;  // of all
};
// Throws patient::DataError.
Result soak(const Settings&);

// Nothing where all is well.
std::vector<std::string> complaintsOf(const Result&, const Settings&);
std::string reportOf(const Result&);
void writeJson(const Result&, const Settings&, const std::filesystem::path& file);

}  // namespace stylet::soak
