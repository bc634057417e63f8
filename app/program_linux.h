// Start and end of every program that people run. Protects the program's work from closed streams, broken
// pipes and the user's locale.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace stylet {

// Parses the command line and calls `work`. A closed standard stream is connected to /dev/null, so that the
// next opened file does not take its place. A closed output pipe neither ends the program nor counts as an
// error. Numbers use the C locale.
// Returns the exit status: that of `work`, or 100 if the command line is wrong, 3 for an EnvironmentError,
// and 2 for any other error. Incomplete output on standard output also gives 2. Prints the error, starting
// with the app's name.
int runProgram(CLI::App& app, int argc, char** argv, const std::function<int()>& work);

}  // namespace stylet
