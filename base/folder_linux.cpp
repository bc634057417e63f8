#include "base/folder_linux.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/errors.h"

namespace stylet {

void requireFolder(const std::filesystem::path& folder, const std::string& what) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw DataError(folder, what, "cannot be made: " + error.message());
    if (access(folder.c_str(), W_OK | X_OK) != 0)
        throw DataError(folder, what, std::string("cannot be written to: ") + std::strerror(errno));
}

}  // namespace stylet
