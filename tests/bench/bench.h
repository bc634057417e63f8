// Speed against error. A bench is a function that appends rows. It registers itself under its name:
//   const bench::Registration registration("haptics.sampling_step", run);
// `stylet-bench [--only PREFIX] [--long] [--out FILE.json]` runs the benches whose name begins with PREFIX.
#pragma once

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "base/statistics.h"

namespace stylet::bench {

// One setting of one knob: its run time and its error against the reference.
struct Row {
    std::string name;
    std::string knob;  // with its unit
    double value = 0.0;
    double time_ms = 0.0;  // median
    double error = 0.0;
    std::string error_unit;
    std::string reference;  // what the error is measured against
    std::string note;
};

using Bench = void (*)(std::vector<Row>&);

struct Registration {
    Registration(const char* name, Bench);
};

// --long: run long enough to support a claim. The normal form only shows that the bench works.
bool isLongRun();
void setLongRun(bool);

inline double elapsed_ms(std::chrono::steady_clock::time_point since) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - since).count();
}

// Median time of one call of work().
template <typename Work>
double medianTime_ms(int runs, const Work& work) {
    std::vector<double> times_ms;
    for (int i = 0; i < runs; ++i) {
        const auto began = std::chrono::steady_clock::now();
        work();
        times_ms.push_back(elapsed_ms(began));
    }
    return median(times_ms);
}

}  // namespace stylet::bench
