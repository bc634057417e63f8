// The subcommand `stylet-model import`.
#pragma once

#include <CLI/App.hpp>

namespace stylet::app {

void addImport(CLI::App&);

}  // namespace stylet::app
