// Start and end of every program that people run. Protects the program's work from closed streams, broken
// pipes and the user's locale.
#pragma once

namespace stylet {

// Runs `program` and returns its status. A closed standard stream is connected to /dev/null, so that the
// next opened file does not take its place. A closed output pipe neither ends the program nor counts as an
// error. Numbers use the C locale. If standard output could not be written completely for another reason,
// prints an error and returns 2, unless `program` failed with its own status.
int runProgram(const char* name, int (*program)(int, char**), int argc, char** argv);

}  // namespace stylet
