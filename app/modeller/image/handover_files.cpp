#include "app/modeller/image/handover_files.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>

#include "app/modeller/image/child_process_linux.h"
#include "app/modeller/image/image_handover.h"

namespace stylet::modeller {

namespace fs = std::filesystem;

namespace {

constexpr double kFarthest_mm = 1e4;  // maximum displacement

// Returns the grid described by a file's header. Checks all sizes, so that a damaged header causes no huge
// allocation later. If a value is out of bounds, sets `wrong` to the reason and returns nullopt.
template <typename Header>
std::optional<Grid> gridOf(const Header& h, std::uintmax_t file_bytes, std::size_t voxel_bytes,
                           std::string& wrong) {
    const auto bad = [&](const char* why) {
        wrong = why;
        return std::nullopt;
    };
    std::int64_t count = 1;
    Grid grid;
    for (int d = 0; d < 3; ++d) {
        const auto i = std::size_t(d);
        if (h.dims[i] < 1 || h.dims[i] > kMaxImageSide) return bad("an image of impossible size");
        if (!(h.spacing_mm[i] >= 0.05 && h.spacing_mm[i] <= 20.0) || !(std::fabs(h.origin_mm[i]) < 1e5))
            return bad("an image of impossible scale");
        count *= h.dims[i];
        grid.dims[d] = int(h.dims[i]);
        grid.spacing_m[d] = h.spacing_mm[i] * 1e-3;
        grid.origin_m[d] = h.origin_mm[i] * 1e-3;
    }
    if (count > kMaxImageVoxels || file_bytes != sizeof h + std::uintmax_t(count) * voxel_bytes)
        return bad("an image cut short");
    return grid;
}

// Refuses anything but regular files, because opening others could block.
template <typename Header>
bool beginOf(const fs::path& file, std::ifstream& in, Header& h) {
    const auto magic = h.magic;
    if (!fs::is_regular_file(fs::symlink_status(file))) return false;
    in.open(file, std::ios::binary);
    return in.read(reinterpret_cast<char*>(&h), sizeof h) && h.magic == magic;
}

template <typename Voxel>
bool voxelsOf(std::ifstream& in, Volume<Voxel>& volume) {
    return bool(in.read(reinterpret_cast<char*>(volume.voxels.data()),
                        std::streamsize(volume.voxels.size() * sizeof(Voxel))));
}

}  // namespace

Volume<std::int16_t> takeImage(const fs::path& file, const fs::path& source, ImageKind kind) {
    const auto bad = [&](const std::string& why) {
        return ImportError(source.string() + ": the reader returned " + why);
    };
    std::ifstream in;
    ImageHandover h;
    if (!beginOf(file, in, h)) throw bad("no image");
    std::string wrong;
    const auto grid = gridOf(h, fs::file_size(file), sizeof(std::int16_t), wrong);
    if (!grid) throw bad(wrong);
    Volume<std::int16_t> image(*grid);
    if (!voxelsOf(in, image)) throw bad("too little");
    if (kind == ImageKind::labels) {
        const auto lowest = std::min_element(image.voxels.begin(), image.voxels.end());
        if (*lowest < 0) throw bad("a label of " + std::to_string(*lowest) + ", which is below 0");
    }
    return image;
}

VectorField takeField(const fs::path& file) {
    const auto bad = [&](const std::string& why) {
        return ImportError(file.string() + ": the registration left " + why);
    };
    std::ifstream in;
    FieldHandover h;
    if (!beginOf(file, in, h)) throw bad("no field");
    static_assert(sizeof(glm::vec3) == 3 * sizeof(float));
    std::string wrong;
    const auto grid = gridOf(h, fs::file_size(file), sizeof(glm::vec3), wrong);
    if (!grid) throw bad(wrong);
    VectorField field(*grid);
    if (!voxelsOf(in, field)) throw bad("a field cut short");
    for (glm::vec3& v : field.voxels) {
        for (int d = 0; d < 3; ++d)
            if (!(std::fabs(double(v[d])) <= kFarthest_mm)) throw bad("a place that cannot be");
        v *= 1e-3f;
    }
    return field;
}

}  // namespace stylet::modeller
