// The subcommand `stylet-model import`.
#pragma once

#include <CLI/App.hpp>

namespace stylet::modeller {

void addImport(CLI::App&);

}  // namespace stylet::modeller
