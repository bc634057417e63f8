// Clients that draw into swapchains and check the pictures that the runtime wrote.
#pragma once

#include "tests/xr/mock/client/client.h"

namespace mock_test {

using Rgb = std::array<std::uint8_t, 3>;
using Rgba = std::array<std::uint8_t, 4>;

struct Picture {
    int width = 0, height = 0;
    std::vector<Rgb> pixels;
    Rgb at(int x, int y) const { return pixels[static_cast<std::size_t>(y * width + x)]; }
};

Picture readPicture(const std::filesystem::path& path);  // empty if the file does not exist

XrCompositionLayerCylinderKHR cylinderLayer(XrSpace space, const Swapchain& swapchain, float radius_m,
                                            float angle_rad, float aspect_ratio);
XrQuaternionf turned(double angle_rad, XrVector3f unit_axis);
// A pattern with soft and hard edges and varying alpha.
std::vector<Rgba> pattern(int width, int height, int cells);

class PictureTest : public MockTest {
  protected:
    void TearDown() override;

    // A swapchain filled with these texels. Their number determines the number of array layers.
    Swapchain picture(std::uint32_t width, std::uint32_t height, const std::vector<Rgba>& texels,
                      VkFormat format = VK_FORMAT_R8G8B8A8_SRGB);
    // Acquires an image, copies the texels unchanged into its layers, and releases it. Does not wait for the
    // GPU.
    void draw(const Swapchain& swapchain, const std::vector<Rgba>& texels);
    // Reads back the unchanged texels of an image that was drawn before.
    std::vector<Rgba> readTexels(const Swapchain& swapchain, VkImage image, std::uint32_t layers);
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
