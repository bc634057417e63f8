#include "app/modeller/image/handover_files.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>

#include "app/modeller/image/image_handover.h"
#include "app/modeller/image/import_error.h"
#include "base/whole_file.h"

namespace stylet::modeller {

namespace fs = std::filesystem;

namespace {

constexpr double kMaxDisplacement_mm = 1e4, kMaxScale = 10.0;

// Returns the grid described by a file's header. Checks all sizes, so that a damaged header causes no huge
// allocation later.
template <typename Bad>
Grid parseGrid(const ImageHandover& h, std::uintmax_t file_bytes, std::size_t voxel_bytes, const Bad& bad) {
    std::int64_t count = 1;
    Grid grid;
    for (int d = 0; d < 3; ++d) {
        const auto i = std::size_t(d);
        if (h.dims[i] < 1 || h.dims[i] > kMaxImageSide) throw bad("an image of impossible size");
        if (!(h.spacing_mm[i] >= 0.05 && h.spacing_mm[i] <= 20.0) || !(std::fabs(h.origin_mm[i]) < 1e5))
            throw bad("an image of impossible scale");
        count *= h.dims[i];
        grid.dims[d] = int(h.dims[i]);
        grid.spacing_m[d] = h.spacing_mm[i] * 1e-3;
        grid.origin_m[d] = h.origin_mm[i] * 1e-3;
    }
    if (count > kMaxImageVoxels || file_bytes != sizeof h + std::uintmax_t(count) * voxel_bytes)
        throw bad("an image cut short");
    return grid;
}

// Reads a file with this magic. Refuses anything but regular files, because opening others could block.
// `bad` makes the error from the reason.
template <typename Voxel, typename Bad>
Volume<Voxel> readVolume(const fs::path& file, const std::array<char, 8>& magic, const Bad& bad) {
    ImageHandover h;
    std::ifstream in;
    if (fs::is_regular_file(fs::symlink_status(file))) in.open(file, std::ios::binary);
    if (!in.is_open() || !in.read(reinterpret_cast<char*>(&h), sizeof h) || h.magic != magic)
        throw bad("no image");
    Volume<Voxel> volume(parseGrid(h, fs::file_size(file), sizeof(Voxel), bad));
    if (!in.read(reinterpret_cast<char*>(volume.voxels.data()),
                 std::streamsize(volume.voxels.size() * sizeof(Voxel))))
        throw bad("an image cut short");
    return volume;
}

}  // namespace

Volume<std::int16_t> readImageFile(const fs::path& file, const fs::path& source, ImageKind kind) {
    const auto bad = [&](const std::string& why) {
        return ImportError(source.string() + ": the reader returned " + why);
    };
    const auto image = readVolume<std::int16_t>(file, kImageMagic, bad);
    if (kind == ImageKind::labels) {
        const auto lowest = std::min_element(image.voxels.begin(), image.voxels.end());
        if (*lowest < 0) throw bad(fmt::format("a label of {}, which is below 0", *lowest));
    }
    return image;
}

void writeImageFile(const fs::path& file, const Volume<std::int16_t>& image) {
    ImageHandover h;
    for (int d = 0; d < 3; ++d) {
        h.dims[std::size_t(d)] = image.grid.dims[d];
        h.spacing_mm[std::size_t(d)] = 1e3 * image.grid.spacing_m[d];
        h.origin_mm[std::size_t(d)] = 1e3 * image.grid.origin_m[d];
    }
    const std::size_t voxel_bytes = image.voxels.size() * sizeof image.voxels[0];
    std::string bytes(sizeof h + voxel_bytes, '\0');
    std::memcpy(bytes.data(), &h, sizeof h);
    std::memcpy(bytes.data() + sizeof h, image.voxels.data(), voxel_bytes);
    writeFile(file, bytes);
}

VectorField readFieldFile(const fs::path& file) {
    const auto bad = [&](const std::string& why) {
        return ImportError(file.string() + ": the registration left " + why);
    };
    static_assert(sizeof(glm::vec3) == 3 * sizeof(float));
    auto field = readVolume<glm::vec3>(file, kFieldMagic, bad);
    for (glm::vec3& v : field.voxels) {
        for (int d = 0; d < 3; ++d)
            if (!(std::fabs(double(v[d])) <= kMaxDisplacement_mm)) throw bad("a place that cannot be");
        v *= 1e-3f;
    }
    return field;
}

AffineMap readAffineFile(const fs::path& file) {
    const ImportError bad(file.string() + ": the registration left no transform");
    AffineHandover h;
    std::ifstream in;
    if (fs::is_regular_file(fs::symlink_status(file))) in.open(file, std::ios::binary);
    if (!in.is_open() || !in.read(reinterpret_cast<char*>(&h), sizeof h) || h.magic != kAffineMagic ||
        fs::file_size(file) != sizeof h)
        throw bad;
    AffineMap map;
    for (int row = 0; row < 3; ++row) {
        const auto r = std::size_t(row);
        map.centre_m[row] = 1e-3 * h.centre_mm[r], map.shift_m[row] = 1e-3 * h.shift_mm[r];
        if (!(std::fabs(h.centre_mm[r]) <= kMaxDisplacement_mm) ||
            !(std::fabs(h.shift_mm[r]) <= kMaxDisplacement_mm))
            throw bad;
        for (int column = 0; column < 3; ++column) {
            const double v = h.matrix[r][std::size_t(column)];
            if (!(std::fabs(v) <= kMaxScale)) throw bad;
            map.matrix[column][row] = v;
        }
    }
    return map;
}

}  // namespace stylet::modeller
