// The fault matrix: which program was tested under which fault, and the outcome. It is printed after the
// tests and written to build/PRESET/faults.md.
#pragma once

#include <string>

namespace stylet::test {

struct FaultRow {
    std::string program, fault, outcome;
    bool failed = false;
};

// Adds the row of a finished test.
void addFaultRow(const FaultRow&);

}  // namespace stylet::test
