#include "tests/xr/mock/client/reference_compositor.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace mock_test {

namespace {

using Vec3 = std::array<double, 3>;
using Colour = std::array<double, 4>;  // linear, premultiplied

Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// v + 2 q x (q x v + w v), for a quaternion that is normalised first.
Vec3 rotate(const XrQuaternionf& quaternion, const Vec3& v, double sign) {
    const double length =
        std::sqrt(double{quaternion.x} * quaternion.x + double{quaternion.y} * quaternion.y +
                  double{quaternion.z} * quaternion.z + double{quaternion.w} * quaternion.w);
    const Vec3 q{sign * quaternion.x / length, sign * quaternion.y / length, sign * quaternion.z / length};
    const double w = quaternion.w / length;
    Vec3 inner = cross(q, v);
    for (std::size_t i = 0; i < 3; ++i)
        inner[i] += w * v[i];
    const Vec3 outer = cross(q, inner);
    return {v[0] + 2 * outer[0], v[1] + 2 * outer[1], v[2] + 2 * outer[2]};
}

struct Ray {
    Vec3 origin, direction;  // in the stage
};

Ray rayThrough(const XrPosef& stage_from_eye, const XrFovf& fov, double u, double v) {
    const double left = std::tan(double{fov.angleLeft}), right = std::tan(double{fov.angleRight});
    const double up = std::tan(double{fov.angleUp}), down = std::tan(double{fov.angleDown});
    const Vec3 in_eye{left + (right - left) * u, up + (down - up) * v, -1};
    const XrVector3f& p = stage_from_eye.position;
    return {{p.x, p.y, p.z}, rotate(stage_from_eye.orientation, in_eye, 1)};
}

using Point = std::array<double, 2>;

// Returns where the ray meets the layer's surface: (0, 0) is the top left corner of the sub-image, (1, 1) the
// bottom right. The point may lie outside the sub-image.
std::optional<Point> intersect(const ReferenceLayer& layer, const Ray& ray) {
    const XrVector3f& p = layer.stage_from_layer.position;
    const Vec3 from{ray.origin[0] - p.x, ray.origin[1] - p.y, ray.origin[2] - p.z};
    const Vec3 d = rotate(layer.stage_from_layer.orientation, ray.direction, -1);
    const Vec3 o = rotate(layer.stage_from_layer.orientation, from, -1);
    if (layer.type == XR_TYPE_COMPOSITION_LAYER_PROJECTION) {
        if (d[2] >= 0) return std::nullopt;
        const double left = std::tan(double{layer.fov.angleLeft}), up = std::tan(double{layer.fov.angleUp});
        const double right = std::tan(double{layer.fov.angleRight});
        const double down = std::tan(double{layer.fov.angleDown});
        return Point{(-d[0] / d[2] - left) / (right - left), (up + d[1] / d[2]) / (up - down)};
    }
    if (layer.type == XR_TYPE_COMPOSITION_LAYER_QUAD) {
        if (o[2] <= 0 || d[2] >= 0) return std::nullopt;
        const double t = -o[2] / d[2];
        return Point{0.5 + (o[0] + t * d[0]) / layer.size_m.width,
                     0.5 - (o[1] + t * d[1]) / layer.size_m.height};
    }
    const double height_per_radius = layer.angle_rad / layer.aspect_ratio;
    const double a = d[0] * d[0] + d[2] * d[2];
    double x = d[0], z = d[2], y_per_radius = d[1] / std::sqrt(a);
    if (layer.radius_m > 0 && std::isfinite(layer.radius_m)) {
        const double r = layer.radius_m, b = o[0] * d[0] + o[2] * d[2];
        const double root = b * b - a * (o[0] * o[0] + o[2] * o[2] - r * r);
        if (root < 0) return std::nullopt;
        const double t = (std::sqrt(root) - b) / a;
        if (t <= 0) return std::nullopt;
        x = o[0] + t * d[0];
        z = o[2] + t * d[2];
        y_per_radius = (o[1] + t * d[1]) / r;
    }
    return Point{0.5 + std::atan2(x, -z) / layer.angle_rad, 0.5 - y_per_radius / height_per_radius};
}

Colour texel(const ReferenceLayer& layer, int x, int y) {
    const int column = std::clamp(x, 0, layer.width - 1), row = std::clamp(y, 0, layer.height - 1);
    const Rgba& stored = layer.texels[static_cast<std::size_t>(row * layer.width + column)];
    Colour colour{linearFromSrgb(stored[0] / 255.0), linearFromSrgb(stored[1] / 255.0),
                  linearFromSrgb(stored[2] / 255.0), stored[3] / 255.0};
    if ((layer.flags & XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT) == 0) colour[3] = 1;
    if ((layer.flags & XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT) != 0)
        for (std::size_t i = 0; i < 3; ++i)
            colour[i] *= colour[3];
    return colour;
}

void addBilinear(const ReferenceLayer& layer, const Point& at, double weight, Colour& sum) {
    const double x = at[0] * layer.width - 0.5, y = at[1] * layer.height - 0.5;
    const double fx = x - std::floor(x), fy = y - std::floor(y);
    for (int j = 0; j < 2; ++j) {
        for (int i = 0; i < 2; ++i) {
            const Colour c =
                texel(layer, static_cast<int>(std::floor(x)) + i, static_cast<int>(std::floor(y)) + j);
            const double share = weight * (i == 1 ? fx : 1 - fx) * (j == 1 ? fy : 1 - fy);
            for (std::size_t k = 0; k < 4; ++k)
                sum[k] += share * c[k];
        }
    }
}

// Mean over the pixel's footprint. Takes one sample per texel along each side, at most 8.
Colour sample(const ReferenceLayer& layer, const Point& at, const std::optional<Point>& right,
              const std::optional<Point>& below) {
    Colour colour{};
    if (!right || !below) {
        addBilinear(layer, at, 1, colour);
        return colour;
    }
    const Point dx{(*right)[0] - at[0], (*right)[1] - at[1]}, dy{(*below)[0] - at[0], (*below)[1] - at[1]};
    const double texels = std::max(std::hypot(dx[0] * layer.width, dx[1] * layer.height),
                                   std::hypot(dy[0] * layer.width, dy[1] * layer.height));
    const int n = texels <= 1.01 ? 1 : static_cast<int>(std::min(std::ceil(texels), 8.0));
    const double spread = n == 1 ? 0 : 1 - 1 / texels;  // a sample is already as wide as a texel
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            const double x = spread * ((i + 0.5) / n - 0.5), y = spread * ((j + 0.5) / n - 0.5);
            addBilinear(layer, {at[0] + dx[0] * x + dy[0] * y, at[1] + dx[1] * x + dy[1] * y}, 1.0 / (n * n),
                        colour);
        }
    }
    return colour;
}

}  // namespace

double linearFromSrgb(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}
double srgbFromLinear(double linear) {
    return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

Picture composeReference(const std::vector<ReferenceLayer>& layers, const XrPosef& stage_from_eye,
                         const XrFovf& fov, int width, int height) {
    Picture picture{width, height, {}};
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const auto ray = [&](double px, double py) {
                return rayThrough(stage_from_eye, fov, px / width, py / height);
            };
            Colour painted{};
            for (const ReferenceLayer& layer : layers) {
                const auto at = intersect(layer, ray(x + 0.5, y + 0.5));
                if (!at || !((*at)[0] >= 0 && (*at)[0] <= 1 && (*at)[1] >= 0 && (*at)[1] <= 1)) continue;
                const Colour colour = sample(layer, *at, intersect(layer, ray(x + 1.5, y + 0.5)),
                                             intersect(layer, ray(x + 0.5, y + 1.5)));
                for (std::size_t k = 0; k < 4; ++k)
                    painted[k] = colour[k] + painted[k] * (1 - colour[3]);
            }
            Rgb pixel;
            for (std::size_t k = 0; k < 3; ++k)
                pixel[k] = static_cast<std::uint8_t>(
                    std::lround(255 * srgbFromLinear(std::clamp(painted[k], 0.0, 1.0))));
            picture.pixels.push_back(pixel);
        }
    }
    return picture;
}

Difference compare(const Picture& a, const Picture& b) {
    Difference difference;
    if (a.width != b.width || a.height != b.height || a.pixels.empty()) return {255, 0, 1};
    double squares = 0;
    std::size_t over_one = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
        int worst = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const int off = std::abs(int{a.pixels[i][k]} - int{b.pixels[i][k]});
            squares += off * off;
            worst = std::max(worst, off);
        }
        difference.largest = std::max(difference.largest, worst);
        over_one += worst > 1 ? 1 : 0;
    }
    const auto count = static_cast<double>(a.pixels.size());
    difference.psnr_db = squares == 0 ? 99 : 10 * std::log10(255.0 * 255.0 * 3 * count / squares);
    difference.share_over_one = static_cast<double>(over_one) / count;
    return difference;
}

}  // namespace mock_test
