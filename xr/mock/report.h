// XRMOCK_REPORT=STEM: what became of a run, as STEM.txt and, in the format of JUnit, STEM.xml. Failed
// assertions are told on stderr whether or not there is a report.
#pragma once

namespace xrmock {

struct Instance;

// When the instance goes.
void report(const Instance& instance);
// Instances that are still there when the process exits are reported then, the log is written out, and the
// socket is removed.
void reportAtExit();

}  // namespace xrmock
