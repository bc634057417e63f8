// Loads a picture file.
#pragma once

#include <stb/stb_image.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

namespace stylet::test {

struct Picture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  // top row first
    const std::uint8_t* at(int x, int y) const {
        return &rgb[3 * (std::size_t(y) * std::size_t(width) + std::size_t(x))];
    }
};

// Empty if the file cannot be read. The test must link stb.
inline Picture loadPicture(const std::filesystem::path& file) {
    Picture picture;
    int channels = 0;
    const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
        stbi_load(file.c_str(), &picture.width, &picture.height, &channels, 3), stbi_image_free);
    if (pixels) picture.rgb.assign(pixels.get(), pixels.get() + 3 * picture.width * picture.height);
    return picture;
}

}  // namespace stylet::test
