// The commands of stylet-model. Each function adds one command to the command line.
#pragma once

#include <CLI/CLI.hpp>

namespace stylet::modeller {

void addBuild(CLI::App&);
void addCompare(CLI::App&);
void addSynth(CLI::App&);
void addCheck(CLI::App&);
void addSlices(CLI::App&);
void addImport(CLI::App&);
void addMotion(CLI::App&);

}  // namespace stylet::modeller
