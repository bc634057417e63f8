#include "base/cache_file.h"

#include <chrono>
#include <random>
#include <system_error>

#include "base/errors.h"
#include "base/whole_file.h"

namespace stylet {

namespace fs = std::filesystem;

namespace {

constexpr std::chrono::hours kStaleAge{1};

bool isTemporaryOf(const std::string& found, const std::string& name) {
    const std::size_t dot = found.rfind('.');
    if (dot == std::string::npos || dot + 1 == found.size()) return false;
    return (name.empty() || found.compare(0, dot, name) == 0) &&
           found.find_first_not_of("0123456789", dot + 1) == std::string::npos;
}

}  // namespace

void writeCacheFile(const fs::path& file, std::initializer_list<std::span<const std::byte>> parts) {
    std::error_code error;
    if (file.has_parent_path()) fs::create_directories(file.parent_path(), error);
    if (error) throw DataError(file.parent_path(), "folder", "cannot be made: " + error.message());
    std::string bytes;
    for (const std::span<const std::byte> part : parts)
        bytes.append(reinterpret_cast<const char*>(part.data()), part.size());
    const fs::path fresh = file.string() + "." + std::to_string(std::random_device{}());
    try {
        writeFile(fresh, bytes);
        fs::rename(fresh, file, error);
        if (error) throw DataError(file, "file", "cannot be written: " + error.message());
    } catch (...) {
        std::error_code ignored;
        fs::remove(fresh, ignored);
        throw;
    }
}

void removeStaleTemporaryFiles(const fs::path& folder, const std::string& name) {
    std::error_code end;
    for (fs::directory_iterator entry(folder, end), none; !end && entry != none; entry.increment(end)) {
        if (!isTemporaryOf(entry->path().filename().string(), name)) continue;
        std::error_code gone;  // ignored: another program may have removed the file
        const auto written = entry->last_write_time(gone);
        if (!gone && entry->is_regular_file(gone) && fs::file_time_type::clock::now() - written > kStaleAge)
            fs::remove(entry->path(), gone);
    }
}

}  // namespace stylet
