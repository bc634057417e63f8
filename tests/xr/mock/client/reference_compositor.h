// A reference compositor in double precision on the CPU. Unlike the GPU's implementation, it traces rays in
// the stage frame. The tests compare the GPU's pictures with its pictures.
#pragma once

#include <vector>

#include "tests/xr/mock/client/pictures.h"

namespace mock_test {

struct ReferenceLayer {
    XrStructureType type = XR_TYPE_COMPOSITION_LAYER_QUAD;
    XrPosef stage_from_layer = kIdentity;                 // projection: the submitted eye
    XrFovf fov{};                                         // projection
    XrExtent2Df size_m{};                                 // quad
    float radius_m = 0, angle_rad = 0, aspect_ratio = 0;  // cylinder
    XrCompositionLayerFlags flags = 0;
    std::vector<Rgba> texels;  // sRGB, of the sub-image
    int width = 0, height = 0;
};

// The caller must omit layers that this eye does not see.
Picture composeReference(const std::vector<ReferenceLayer>& layers, const XrPosef& stage_from_eye,
                         const XrFovf& fov, int width, int height);

double linearFromSrgb(double encoded);  // both 0 to 1
double srgbFromLinear(double linear);

struct Difference {
    int largest = 0;  // out of 255
    double psnr_db = 0;
    double share_over_one = 0;  // share of the pixels that differ by more than 1
};
Difference compare(const Picture& a, const Picture& b);

}  // namespace mock_test
