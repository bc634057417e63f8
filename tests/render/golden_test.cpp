// Small pictures that were approved by eye, for properties of a look that numbers cannot capture. Only
// tests/render/approve updates them.
#include <gtest/gtest.h>

#include <stb_image.h>
#include <stb_image_write.h>
#include <cstdlib>

#include "tests/render/gpu_fixture.h"
#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"
#include "tests/support/temp_folder.h"

namespace stylet::render {
namespace {

constexpr std::uint32_t kWidth = 128, kHeight = 96;
constexpr double kMinPsnr_db = 36.0;  // tolerates a few values at edges on other drivers or processors

struct GoldenPicture {
    const char* name;
    RenderScene scene;
    Vec3 eye_m;
};

std::vector<GoldenPicture> goldenPictures() {
    RenderScene reveal;
    reveal.stage_from_patient.position_m = {0.0, 1.0, 0.0};
    reveal.patient_from_needle = Pose{glm::angleAxis(1.2, Vec3(0, 1, 0)), Vec3(0.06, 0.0, 0.0)};
    reveal.reference_path_m = std::array<Vec3, 2>{Vec3(0.15, 0.02, 0.0), Vec3(0.06, 0.0, 0.0)};
    RenderScene closed = reveal;
    closed.look = Look::closed;
    closed.reference_path_m.reset();
    closed.marks = {{MarkKind::iodine, Vec3(0.14, 0.03, 0.0), 0.05, Vec3(0, 0, 1)},
                    {MarkKind::blood, Vec3(0.148, 0.015, 0.0), 0.008, Vec3(0, -1, 0)}};
    RenderScene room = closed;
    room.room = wholeRoom();
    room.field_m = Vec3(0.14, 0.03, 0.0);
    room.drape = true;
    RenderScene section = closed;
    section.cuts = {{Vec3(0.0, 0.0, 1.0), 0.0}};
    return {{"reveal", reveal, Vec3(0.35, 1.35, 0.35)},
            {"closed", closed, Vec3(0.35, 1.30, 0.30)},
            {"section", section, Vec3(0.20, 1.25, 0.45)},
            {"room", room, Vec3(1.1, 1.8, 1.3)}};
}

std::filesystem::path expectedFile(const std::string& name, std::size_t eye) {
    return std::filesystem::path(STYLET_EXPECTED_PICTURES) / (name + (eye == 0 ? "_left.png" : "_right.png"));
}

void save(const Image& image, const std::filesystem::path& file) {
    ASSERT_NE(stbi_write_png(file.c_str(), int(image.width), int(image.height), 4, image.rgba.data(),
                             int(4 * image.width)),
              0)
        << file;
}

Image load(const std::filesystem::path& file) {
    int width = 0, height = 0, channels = 0;
    stbi_uc* pixels = stbi_load(file.c_str(), &width, &height, &channels, 4);
    if (!pixels) return {};
    Image image{std::uint32_t(width), std::uint32_t(height), {}};
    image.rgba.assign(pixels, pixels + std::size_t(width) * std::size_t(height) * 4);
    stbi_image_free(pixels);
    return image;
}

class Golden : public test::GpuFixture<testing::TestWithParam<VolumePath>> {};

TEST_P(Golden, PicturesMatchTheApprovedOnes) {
    test::PatientRenderer shown(test::makeTrunk(0.003), {.volume_path = GetParam()});
    Renderer& renderer = shown.renderer;
    const bool approve = std::getenv("STYLET_APPROVE") != nullptr && GetParam() == VolumePath::gpu;
    for (const GoldenPicture& golden : goldenPictures()) {
        const auto eyes = test::stereo(test::lookAt(golden.eye_m, Vec3(0.03, 1.0, 0.0), 0.42f), 0.063);
        const auto seen = renderer.drawToImages(golden.scene, eyes, kWidth, kHeight);
        for (std::size_t eye = 0; eye < 2; ++eye) {
            const std::filesystem::path file = expectedFile(golden.name, eye);
            if (approve) save(seen[eye], file);
            const Image expected = load(file);
            ASSERT_EQ(expected.rgba.size(), seen[eye].rgba.size()) << file;
            const double psnr_db = test::psnr(seen[eye], expected);
            EXPECT_GE(psnr_db, kMinPsnr_db) << file;
            if (psnr_db < kMinPsnr_db) save(seen[eye], "seen_" + file.filename().string());
        }
    }
}

INSTANTIATE_TEST_SUITE_P(GpuAndProcessor, Golden, testing::Values(VolumePath::gpu, VolumePath::processor));

}  // namespace
}  // namespace stylet::render
