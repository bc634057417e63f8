// Minimal PNG encoder (ISO/IEC 15948): one IDAT chunk, 8-bit RGB, no filter.
#include "compositor/png.h"

#include <unistd.h>
#include <zlib.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string_view>

namespace xrmock {

namespace {

void appendBigEndian(std::string& out, std::uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8)
        out.push_back(static_cast<char>(value >> shift & 0xFF));
}

void appendChunk(std::string& out, std::string_view type, std::string_view data) {
    appendBigEndian(out, static_cast<std::uint32_t>(data.size()));
    const std::size_t start = out.size();
    out.append(type).append(data);
    const auto* bytes = reinterpret_cast<const Bytef*>(out.data() + start);
    appendBigEndian(out, static_cast<std::uint32_t>(crc32(0, bytes, static_cast<uInt>(out.size() - start))));
}

std::string compressRows(std::uint32_t width, std::uint32_t height, const std::vector<std::uint8_t>& rgba) {
    std::string rows;
    rows.reserve((std::size_t{width} * 3 + 1) * height);
    const std::uint8_t* pixel = rgba.data();
    for (std::uint32_t y = 0; y < height; ++y) {
        rows.push_back('\0');  // filter type: none
        for (std::uint32_t x = 0; x < width; ++x, pixel += 4)
            rows.append(reinterpret_cast<const char*>(pixel), 3);
    }
    uLongf size = compressBound(rows.size());
    std::string packed(size, '\0');
    if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
                  rows.size(), 3) != Z_OK) {
        throw std::runtime_error("a picture could not be compressed");
    }
    packed.resize(size);
    return packed;
}

}  // namespace

std::string encodePng(std::uint32_t width, std::uint32_t height, const std::vector<std::uint8_t>& rgba) {
    std::string header;
    appendBigEndian(header, width);
    appendBigEndian(header, height);
    header.append({8, 2, 0, 0, 0});  // bits, colour type RGB, deflate, filters, not interlaced
    std::string file = "\x89PNG\r\n\x1a\n";
    appendChunk(file, "IHDR", header);
    appendChunk(file, "IDAT", compressRows(width, height, rgba));
    appendChunk(file, "IEND", "");
    return file;
}

void writeFile(const std::string& file_name, const std::string& bytes) {
    const std::string temporary = file_name + "." + std::to_string(getpid()) + ".part";
    std::ofstream stream(temporary, std::ios::binary);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    std::error_code error;
    if (stream) std::filesystem::rename(temporary, file_name, error);
    if (!stream || error) {
        std::remove(temporary.c_str());
        throw std::runtime_error(file_name + " cannot be written");
    }
}

}  // namespace xrmock
