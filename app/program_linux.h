// What every program that people start begins and ends with: nothing that its surroundings lack or break may
// cost what it keeps.
#pragma once

namespace stylet {

// Runs `program` and returns its status. A standard stream that was closed leads nowhere, instead of into the
// next file that is opened; who stops reading our words does not stop the work; numbers are written as in C,
// wherever the user comes from. Words that could not be written are an error of their own: status 2.
int runProgram(const char* name, int (*program)(int, char**), int argc, char** argv);

}  // namespace stylet
