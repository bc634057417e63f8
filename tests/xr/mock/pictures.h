// Clients that draw into swapchains and look at the pictures that the runtime wrote.
#pragma once

#include "client.h"

namespace mock_test {

using Rgb = std::array<std::uint8_t, 3>;
using Rgba = std::array<std::uint8_t, 4>;

struct Picture {
    int width = 0, height = 0;
    std::vector<Rgb> pixels;
    Rgb at(int x, int y) const { return pixels[static_cast<std::size_t>(y * width + x)]; }
};

Picture readPicture(const std::filesystem::path& path);  // empty if there is none

class PictureTest : public MockTest {
  protected:
    void TearDown() override;

    // Acquires an image, copies the texels into it as they are, layer by layer, and releases it; does not
    // wait for the GPU.
    void draw(const Swapchain& swapchain, const std::vector<Rgba>& texels);
    // The texels of an image that was drawn before, as they are.
    std::vector<Rgba> texelsOf(const Swapchain& swapchain, VkImage image, std::uint32_t layers);
    void label(const char* name);

  private:
    template <class Record>
    void submitCommands(Record record);
    void move(VkCommandBuffer commands, VkImage image, VkImageLayout from, VkImageLayout to);
    void makeStaging(std::size_t size);

    std::vector<VkCommandPool> pools_;
    VkBuffer staging_ = VK_NULL_HANDLE;
    VkDeviceMemory staging_memory_ = VK_NULL_HANDLE;
};

}  // namespace mock_test
