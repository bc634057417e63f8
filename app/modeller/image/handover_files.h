// Writes the input files and reads the output files of the child processes (image_handover.h). A child may
// have read a hostile file, so nothing in its output is trusted.
#pragma once

#include <filesystem>
#include <glm/mat3x3.hpp>
#include <string>

#include "app/modeller/image/import_image.h"
#include "app/modeller/image/vector_field.h"

namespace stylet::modeller {

// `source` is the file that the child read, for messages. Throws ImportError.
Volume<std::int16_t> readImageFile(const std::filesystem::path& file, const std::filesystem::path& source,
                                   ImageKind);
// Throws DataError.
void writeImageFile(const std::filesystem::path& file, const Volume<std::int16_t>&);
// In metres. Throws ImportError.
VectorField readFieldFile(const std::filesystem::path& file);

// Maps a point of the fixed image to the same tissue in the moving image.
struct AffineMap {
    glm::dmat3 matrix{1.0};
    Vec3 centre_m{0.0}, shift_m{0.0};
    Vec3 operator()(const Vec3& p_m) const { return matrix * (p_m - centre_m) + centre_m + shift_m; }
};
// Throws ImportError.
AffineMap readAffineFile(const std::filesystem::path& file);

}  // namespace stylet::modeller
