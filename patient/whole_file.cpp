#include "patient/whole_file.h"

#include <cerrno>
#include <fstream>
#include <system_error>

#include "patient/package.h"

namespace stylet::patient {

namespace fs = std::filesystem;

namespace {

DataError refused(const fs::path& file, const std::error_code& why) {
    return {file, "file", "cannot be written" + (why ? ": " + why.message() : "")};
}

// Why not, in the system's words: the first step that failed knows it.
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
    std::error_code error;
    const std::uintmax_t size = fs::file_size(file, error);
    if (error) throw DataError(file, "file", "cannot be opened: " + error.message());
    if (size > max_bytes)
        throw DataError(file, "file", "larger than " + std::to_string(max_bytes) + " bytes");
    std::string bytes(std::size_t(size), '\0');
    std::ifstream in(file, std::ios::binary);
    in.read(bytes.data(), std::streamsize(size));
    if (!in) throw DataError(file, "file", "cannot be read");
    return bytes;
}

void writeFile(const fs::path& file, std::string_view bytes) {
    if (const std::error_code why = tryWriting(file, bytes)) throw refused(file, why);
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
    throw refused(file, why);
}

}  // namespace stylet::patient
