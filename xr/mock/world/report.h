// XRMOCK_REPORT=STEM: writes the result of a run to STEM.txt and, in JUnit format, to STEM.xml. Failed
// assertions are also printed on stderr, with or without a report.
#pragma once

namespace xrmock {

struct Instance;

// Call when the instance is destroyed.
void writeReport(const Instance& instance);
// Registers an exit handler. It reports the instances that are still alive, flushes the log and removes the
// control sockets.
void reportAtExit();

}  // namespace xrmock
