#include "base/whole_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <system_error>

#include "base/errors.h"

namespace stylet {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kReadBytes = 64 << 10;

DataError writeError(const fs::path& file, const std::error_code& why) {
    return {file, "file", "cannot be written" + (why ? ": " + why.message() : "")};
}

// Returns the system's error of the first step that failed.
std::error_code tryWriting(const fs::path& file, std::string_view bytes) {
    const auto reason = [] { return std::error_code(errno != 0 ? errno : EIO, std::generic_category()); };
    errno = 0;
    std::ofstream out(file, std::ios::binary);
    if (!out) return reason();
    if (!out.write(bytes.data(), std::streamsize(bytes.size())) || !out.flush()) return reason();
    out.close();
    return out ? std::error_code() : reason();
}

}  // namespace

std::string readWholeFile(const fs::path& file, std::size_t max_bytes) {
    const auto refuse = [&](const char* what) {
        const std::error_code why(errno, std::generic_category());
        throw DataError(file, "file", what + (why ? ": " + why.message() : ""));
    };
    errno = 0;
    std::ifstream in(file, std::ios::binary);
    if (!in) refuse("cannot be opened");
    // Read to the end, whatever the file's size was before: it may grow or be a pipe.
    std::string bytes;
    while (in && bytes.size() <= max_bytes) {
        const std::size_t had = bytes.size();
        bytes.resize(std::min(max_bytes + 1, had + std::max(kReadBytes, had)));
        in.read(bytes.data() + had, std::streamsize(bytes.size() - had));
        bytes.resize(had + std::size_t(in.gcount()));
    }
    if (in.bad()) refuse("cannot be read");
    if (bytes.size() > max_bytes)
        throw DataError(file, "file", fmt::format("larger than {} bytes", max_bytes));
    return bytes;
}

void writeFile(const fs::path& file, std::string_view bytes) {
    if (const std::error_code why = tryWriting(file, bytes)) throw writeError(file, why);
}

void writeWholeFile(const fs::path& file, std::string_view bytes) {
    std::error_code why;
    const fs::file_type type = fs::symlink_status(file, why).type();
    if (type != fs::file_type::regular && type != fs::file_type::not_found) return writeFile(file, bytes);
    const fs::path fresh = file.string() + ".new";
    why = tryWriting(fresh, bytes);
    if (!why) fs::rename(fresh, file, why);
    if (!why) return;
    std::error_code ignored;
    fs::remove(fresh, ignored);
    throw writeError(file, why);
}

}  // namespace stylet
