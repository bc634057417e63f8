#include "app/modeller/image/raw_image.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace stylet::modeller {

namespace {

// Limits for the conversion HU = slope * stored value + intercept. CT values have 12 bits and are stored as
// whole HU or as tenths of a HU. A slope or an intercept outside these limits is therefore a mistake in the
// file.
constexpr double kMinSlope = 1e-4, kMaxSlope = 100.0, kMaxIntercept = 32768.0;

template <typename T>
void toInt16(const std::vector<char>& bytes, bool labels, const std::string& where, std::int16_t* out,
             std::size_t count) {
    const T* in = reinterpret_cast<const T*>(bytes.data());
    for (std::size_t i = 0; i < count; ++i) {
        const double v = double(in[i]);
        if (labels && !(v >= 0.0 && v <= 32767.0 && v == std::floor(v)))
            refuse(where + "a label of " + formatNumber(v) + " is not a whole number from 0 to 32767");
        if (!std::isfinite(v)) refuse(where + "voxels: some are not numbers");
        out[i] = std::int16_t(std::lround(std::clamp(v, -32768.0, 32767.0)));
    }
}

}  // namespace

std::string formatNumber(double v) {
    return fmt::format("{:.4g}", v);
}
[[noreturn]] void refuse(const std::string& sentence) {
    throw std::runtime_error(sentence);
}

std::string formatDegrees(double cosine) {
    return formatNumber(std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / std::numbers::pi) + " degrees";
}

V3 readAxis(const itk::ImageIOBase& io, unsigned i) {
    const std::vector<double> d = io.GetDirection(i);
    return d.size() == 3 ? V3{d[0], d[1], d[2]} : V3{0.0, 0.0, 0.0};
}

void checkDims(const std::array<std::int64_t, 3>& dims, const std::string& where) {
    for (std::int64_t d : dims)
        if (d < 1 || d > kMaxImageSide)
            refuse(fmt::format("{}size: a side of {} voxels is outside 1 to {}", where, d, kMaxImageSide));
    if (dims[0] * dims[1] * dims[2] > kMaxImageVoxels)
        refuse(fmt::format("{}size: more than {} million voxels; crop the image or make its voxels larger",
                           where, kMaxImageVoxels >> 20));
}

void checkRescale(double slope, double intercept, const std::string& where, const char* slope_field,
                  const char* intercept_field) {
    if (!(slope >= kMinSlope && slope <= kMaxSlope))
        refuse(where + slope_field + ": " + formatNumber(slope) + " makes no HU of the stored values");
    if (!(std::fabs(intercept) <= kMaxIntercept))
        refuse(where + intercept_field + ": " + formatNumber(intercept) +
               " makes no HU of the stored values");
}

RawImage readVolume(itk::ImageIOBase& io, bool labels) {
    RawImage image;
    for (unsigned d = 0; d < 3; ++d) {
        image.dims[d] = std::int64_t(io.GetDimensions(d));
        image.spacing[d] = io.GetSpacing(d);
        image.origin[d] = io.GetOrigin(d);
        image.axes[d] = readAxis(io, d);
    }
    checkDims(image.dims, "");
    image.voxels.resize(std::size_t(image.dims[0] * image.dims[1] * image.dims[2]));
    readVoxels(io, labels, "", image.voxels.data(), image.voxels.size());
    return image;
}

void readVoxels(itk::ImageIOBase& io, bool labels, const std::string& where, std::int16_t* out,
                std::size_t count) {
    if (io.GetNumberOfComponents() != 1) refuse(where + "a colour picture, not a CT slice or a label volume");
    if (std::size_t(io.GetImageSizeInPixels()) != count) refuse(where + "its size disagrees with its header");
    itk::ImageIORegion region(io.GetNumberOfDimensions());
    for (unsigned d = 0; d < io.GetNumberOfDimensions(); ++d)
        region.SetSize(d, io.GetDimensions(d));
    io.SetIORegion(region);
    std::vector<char> bytes(std::size_t(io.GetImageSizeInBytes()));
    io.Read(bytes.data());
    using Type = itk::CommonEnums::IOComponent;
    switch (io.GetComponentType()) {
        case Type::UCHAR:
            return toInt16<unsigned char>(bytes, labels, where, out, count);
        case Type::CHAR:
            return toInt16<signed char>(bytes, labels, where, out, count);
        case Type::USHORT:
            return toInt16<unsigned short>(bytes, labels, where, out, count);
        case Type::SHORT:
            return toInt16<short>(bytes, labels, where, out, count);
        case Type::UINT:
            return toInt16<unsigned int>(bytes, labels, where, out, count);
        case Type::INT:
            return toInt16<int>(bytes, labels, where, out, count);
        case Type::FLOAT:
            return toInt16<float>(bytes, labels, where, out, count);
        case Type::DOUBLE:
            return toInt16<double>(bytes, labels, where, out, count);
        default:
            refuse(where + "voxels of a type this program does not read");
    }
}

}  // namespace stylet::modeller
