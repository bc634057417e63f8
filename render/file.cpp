#include "render/file.h"

#include <fstream>
#include <iterator>

#include "patient/package.h"

namespace stylet::render {

std::string readFile(const std::filesystem::path& file, std::size_t max_bytes) {
    using patient::DataError;
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(file, error);
    if (error) throw DataError(file, "file", error.message());
    if (size > max_bytes) throw DataError(file, "size", std::to_string(size) + " bytes are too many");
    std::ifstream in(file, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    if (bytes.size() != size) throw DataError(file, "file", "could not be read");
    return bytes;
}

}  // namespace stylet::render
