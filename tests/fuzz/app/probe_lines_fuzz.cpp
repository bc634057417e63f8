#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "app/trainer/setup/doctor.h"

// The input is the output of the doctor's child process, mixed with messages from drivers. All findings can
// be printed.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::trainer;
    std::vector<std::string> lines(1);
    for (std::size_t i = 0; i < size; ++i) {
        if (data[i] == '\n')
            lines.emplace_back();
        else
            lines.back() += char(data[i]);
    }
    std::vector<Finding> findings;
    parseProbeLines(lines, findings);
    if (describeFindings(findings, true).empty()) std::abort();
    describeFindings(findings, false);
    return 0;
}
