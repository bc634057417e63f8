#include "app/modeller/check/slices.h"

#include <stb/stb_image_write.h>

#include <algorithm>
#include <array>
#include <future>
#include <new>
#include <string>
#include <utility>

#include "base/whole_file.h"

namespace stylet::modeller {

namespace {

using Palette = std::array<std::array<std::uint8_t, 3>, 256>;

Palette makePalette(const patient::Package& package) {
    Palette palette{};
    for (const patient::Label& l : package.label_table)
        palette[l.id] = l.colour;
    return palette;
}

int normalAxis(Plane plane) {
    return plane == Plane::axial ? 2 : plane == Plane::coronal ? 1 : 0;
}

// The voxel at pixel (u, v) of slice `index`.
Index3 voxelAt(Plane plane, const Index3& dims, int index, int u, int v) {
    if (plane == Plane::axial) return {dims.x - 1 - u, dims.y - 1 - v, index};
    if (plane == Plane::coronal) return {dims.x - 1 - u, index, dims.z - 1 - v};
    return {index, dims.y - 1 - u, dims.z - 1 - v};
}

// The first and last slice that contain a label.
std::pair<int, int> labelledRange(const LabelVolume& labels, int axis) {
    const Index3 dims = labels.grid.dims;
    int first = dims[axis], last = -1;
    forEachVoxel(labels.grid, [&](const Index3& i) {
        if (labels[i] != 0) first = std::min(first, i[axis]), last = std::max(last, i[axis]);
    });
    return last < 0 ? std::pair{0, dims[axis] - 1} : std::pair{first, last};
}

}  // namespace

Picture slicePicture(const patient::Package& package, Plane plane, int index, const Window& window,
                     double label_share) {
    const Index3 dims = package.ct.grid.dims;
    const Palette palette = makePalette(package);
    Picture picture;
    picture.width = plane == Plane::sagittal ? dims.y : dims.x;
    picture.height = plane == Plane::axial ? dims.y : dims.z;
    picture.rgb.resize(std::size_t(picture.width) * std::size_t(picture.height) * 3);
    for (int v = 0; v < picture.height; ++v)
        for (int u = 0; u < picture.width; ++u) {
            const Index3 i = voxelAt(plane, dims, index, u, v);
            const double share = (package.ct[i] - window.level_hu) / window.width_hu + 0.5;
            const double grey = 255.0 * std::clamp(share, 0.0, 1.0);
            const std::uint8_t id = package.labels[i];
            const double over = id == 0 ? 0.0 : label_share;
            std::uint8_t* out =
                &picture.rgb[(std::size_t(v) * std::size_t(picture.width) + std::size_t(u)) * 3];
            for (std::size_t c = 0; c < 3; ++c)
                out[c] = std::uint8_t(grey * (1.0 - over) + palette[id][c] * over + 0.5);
        }
    return picture;
}

Picture montage(const patient::Package& package, Plane plane, int count, int columns, const Window& window,
                double label_share) {
    const auto [first, last] = labelledRange(package.labels, normalAxis(plane));
    const int rows = (count + columns - 1) / columns;
    Picture sheet;
    for (int k = 0; k < count; ++k) {
        // Axial montages start at the head, like films on a light box.
        const double share = (k + 0.5) / count;
        const double along = plane == Plane::axial ? 1.0 - share : share;
        const int at = first + int(along * (last - first + 1));
        const Picture tile = slicePicture(package, plane, at, window, label_share);
        if (sheet.rgb.empty()) {
            sheet.width = tile.width * columns;
            sheet.height = tile.height * rows;
            sheet.rgb.resize(std::size_t(sheet.width) * std::size_t(sheet.height) * 3);
        }
        for (int v = 0; v < tile.height; ++v) {
            const std::size_t row = std::size_t(k / columns * tile.height + v) * std::size_t(sheet.width);
            std::copy_n(&tile.rgb[std::size_t(v) * std::size_t(tile.width) * 3], std::size_t(tile.width) * 3,
                        &sheet.rgb[(row + std::size_t(k % columns * tile.width)) * 3]);
        }
    }
    return sheet;
}

void writePng(const Picture& picture, const std::filesystem::path& path) {
    std::string png;
    const auto writeBytes = [](void* text, void* bytes, int count) {
        static_cast<std::string*>(text)->append(static_cast<const char*>(bytes), std::size_t(count));
    };
    if (stbi_write_png_to_func(writeBytes, &png, picture.width, picture.height, 3, picture.rgb.data(),
                               picture.width * 3) == 0)
        throw std::bad_alloc();
    writeWholeFile(path, png);
}

void writeSlices(const patient::Package& package, const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    // Each row is stored as its difference from the one above. Trying all five filters of PNG on each row
    // takes half as long again and saves 3 % of the bytes. Set here, before there are two threads.
    stbi_write_force_png_filter = 2;
    const Window abdomen;
    const auto write = [&](const std::string& name, Plane plane, int count, int columns) {
        writePng(montage(package, plane, count, columns, abdomen, 0.0), folder / (name + ".png"));
        writePng(montage(package, plane, count, columns, abdomen, 0.45), folder / (name + "-labels.png"));
    };
    // Compressing takes most of the time. Each thread has about half of the pixels.
    auto others = std::async(std::launch::async, [&] {
        write("coronal", Plane::coronal, 12, 4);
        write("sagittal", Plane::sagittal, 12, 6);
    });
    write("axial", Plane::axial, 20, 5);
    others.get();
}

}  // namespace stylet::modeller
