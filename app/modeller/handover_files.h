// What the child processes leave (image_handover.h), taken over: a child may have read a hostile file, so
// nothing of theirs is trusted.
#pragma once

#include <filesystem>
#include <string>

#include "app/modeller/import_image.h"
#include "app/modeller/vector_field.h"

namespace stylet::modeller {

// `source` is what the child read, for messages. Throws ImportError.
patient::Volume<std::int16_t> takeImage(const std::filesystem::path& file,
                                        const std::filesystem::path& source, ImageKind);
// In metres. Throws ImportError.
VectorField takeField(const std::filesystem::path& file);

}  // namespace stylet::modeller
