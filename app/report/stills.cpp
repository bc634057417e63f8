#include "app/report/stills.h"

#include <cairo.h>
#include <stb/stb_image_write.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>

#include "base/whole_file.h"
#include "patient/patient.h"

namespace stylet::report {

namespace fs = std::filesystem;

namespace {

constexpr int kMaxPixels = 8192;  // of either side
constexpr int kJpegQuality = 82;
constexpr std::size_t kMaxStillBytes = 64u << 20;

struct Destroy {
    void operator()(cairo_surface_t* s) const { cairo_surface_destroy(s); }
    void operator()(cairo_t* c) const { cairo_destroy(c); }
};
using Surface = std::unique_ptr<cairo_surface_t, Destroy>;

struct Size {
    int width = 0, height = 0;
};

std::vector<std::uint8_t> readImageFile(const fs::path& file) {
    const std::string bytes = readWholeFile(file, kMaxStillBytes);
    return {bytes.begin(), bytes.end()};
}

// Reads the size from the IHDR chunk, which comes first. Checks its bounds before anything is decoded.
Size pngSize(const std::vector<std::uint8_t>& bytes, const fs::path& file) {
    static constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
    if (bytes.size() < 24 || !std::equal(kMagic.begin(), kMagic.end(), bytes.begin()))
        throw DataError(file, "header", "is not that of a PNG");
    const auto word = [&](std::size_t at) {
        return unsigned(bytes[at]) << 24 | unsigned(bytes[at + 1]) << 16 | unsigned(bytes[at + 2]) << 8 |
               bytes[at + 3];
    };
    const unsigned width = word(16), height = word(20);
    if (width == 0 || height == 0 || width > unsigned(kMaxPixels) || height > unsigned(kMaxPixels))
        throw DataError(file, "size", "is out of bounds");
    return {int(width), int(height)};
}

struct Bytes {
    const std::vector<std::uint8_t>& all;
    std::size_t at = 0;
};

cairo_status_t readPngBytes(void* closure, unsigned char* to, unsigned int count) {
    Bytes& from = *static_cast<Bytes*>(closure);
    if (count > from.all.size() - from.at) return CAIRO_STATUS_READ_ERROR;
    std::memcpy(to, from.all.data() + from.at, count);
    from.at += count;
    return CAIRO_STATUS_SUCCESS;
}

void appendJpegBytes(void* context, void* data, int count) {
    auto& bytes = *static_cast<std::vector<std::uint8_t>*>(context);
    const auto* from = static_cast<const std::uint8_t*>(data);
    bytes.insert(bytes.end(), from, from + count);
}

// "duct_left" -> "duct, left eye"
std::string captionFromName(std::string name) {
    if (name.ends_with("_left")) name.replace(name.size() - 5, 5, ", left eye");
    std::replace(name.begin(), name.end(), '_', ' ');
    return name;
}

}  // namespace

Picture loadStill(const fs::path& png, int max_width) {
    const std::vector<std::uint8_t> bytes = readImageFile(png);
    const Size size = pngSize(bytes, png);
    Bytes from{bytes};
    const Surface whole(cairo_image_surface_create_from_png_stream(&readPngBytes, &from));
    if (const cairo_status_t status = cairo_surface_status(whole.get()); status != CAIRO_STATUS_SUCCESS)
        throw DataError(png, "file", cairo_status_to_string(status));
    const double scale = std::min(1.0, double(max_width) / size.width);
    Picture picture;
    picture.type = "image/jpeg";
    picture.width = std::max(1, int(std::lround(scale * size.width)));
    picture.height = std::max(1, int(std::lround(scale * size.height)));
    const Surface small(cairo_image_surface_create(CAIRO_FORMAT_RGB24, picture.width, picture.height));
    const std::unique_ptr<cairo_t, Destroy> context(cairo_create(small.get()));
    cairo_scale(context.get(), double(picture.width) / size.width, double(picture.height) / size.height);
    cairo_set_source_surface(context.get(), whole.get(), 0.0, 0.0);
    cairo_pattern_set_filter(cairo_get_source(context.get()), CAIRO_FILTER_GOOD);
    cairo_paint(context.get());
    cairo_surface_flush(small.get());
    const unsigned char* rows = cairo_image_surface_get_data(small.get());
    const int stride = cairo_image_surface_get_stride(small.get());
    std::vector<std::uint8_t> rgb;
    rgb.reserve(3 * std::size_t(picture.width) * std::size_t(picture.height));
    for (int j = 0; j < picture.height; ++j)
        for (int i = 0; i < picture.width; ++i) {
            std::uint32_t word = 0;
            std::memcpy(&word, rows + std::ptrdiff_t(j) * stride + std::ptrdiff_t(i) * 4, sizeof word);
            for (const unsigned shift : {16u, 8u, 0u})
                rgb.push_back(std::uint8_t(word >> shift));
        }
    if (!stbi_write_jpg_to_func(&appendJpegBytes, &picture.bytes, picture.width, picture.height, 3,
                                rgb.data(), kJpegQuality))
        throw DataError(png, "file", "cannot be made smaller");
    return picture;
}

Stills loadStills(const fs::path& folder, std::size_t most, int max_width) {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
        const std::string name = entry.path().stem().string();
        if (!entry.is_regular_file() || entry.path().extension() != ".png") continue;
        if (name == "force-depth" || name == "slices" || name.ends_with("_right")) continue;
        files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    Stills stills;
    for (const fs::path& file : files) {
        if (stills.pictures.size() == most) {
            ++stills.left_out;
            continue;
        }
        try {
            stills.pictures.push_back(loadStill(file, max_width));
            stills.pictures.back().caption = captionFromName(file.stem().string());
            stills.pictures.back().alt = "Still of the attempt: " + stills.pictures.back().caption;
        } catch (const DataError& e) {
            stills.warnings.emplace_back(e.what());
        }
    }
    return stills;
}

}  // namespace stylet::report
