// Runs the program `stylet-model` as a user does.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include "tests/support/file_text.h"
#include "tests/support/temp_folder.h"

namespace stylet::test {

struct ModelRun {
    int status = -1;
    std::string out, err;
};

// `arguments` as in a shell.
inline ModelRun runModel(const std::string& arguments) {
    const TempFolder folder;
    const std::filesystem::path out = folder / "out", err = folder / "err";
    const std::string line = "'" + std::string(std::getenv("STYLET_BIN")) + "/stylet-model' " + arguments +
                             " >'" + out.string() + "' 2>'" + err.string() + "'";
    const int status = std::system(line.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, readText(out), readText(err)};
}

}  // namespace stylet::test
