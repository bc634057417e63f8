#include "app/modeller/image/raw_image.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

namespace stylet::modeller {

namespace {

// Limits for the conversion HU = slope * stored value + intercept. CT values have 12 bits and are stored as
// whole HU or as tenths of a HU. A slope or an intercept outside these limits is therefore a mistake in the
// file.
constexpr double kLeastSlope = 1e-4, kLargestSlope = 100.0, kLargestIntercept = 32768.0;

template <typename T>
void toInt16(const std::vector<char>& bytes, bool labels, const std::string& where, std::int16_t* out,
             std::size_t count) {
    const T* in = reinterpret_cast<const T*>(bytes.data());
    for (std::size_t i = 0; i < count; ++i) {
        const double v = double(in[i]);
        if (labels && !(v >= 0.0 && v <= 32767.0 && v == std::floor(v)))
            refuse(where + "a label of " + number(v) + " is not a whole number from 0 to 32767");
        if (!std::isfinite(v)) refuse(where + "voxels: some are not numbers");
        out[i] = std::int16_t(std::lround(std::clamp(v, -32768.0, 32767.0)));
    }
}

}  // namespace

std::string number(double v) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", v);
    return text;
}
[[noreturn]] void refuse(const std::string& sentence) {
    throw std::runtime_error(sentence);
}

std::string degrees(double cosine) {
    return number(std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / std::numbers::pi) + " degrees";
}

V3 axis(const itk::ImageIOBase& io, unsigned i) {
    const std::vector<double> d = io.GetDirection(i);
    return d.size() == 3 ? V3{d[0], d[1], d[2]} : V3{0.0, 0.0, 0.0};
}

void checkDims(const std::array<std::int64_t, 3>& dims, const std::string& where) {
    for (std::int64_t d : dims)
        if (d < 1 || d > kMaxImageSide)
            refuse(where + "size: a side of " + std::to_string(d) + " voxels is outside 1 to " +
                   std::to_string(kMaxImageSide));
    if (dims[0] * dims[1] * dims[2] > kMaxImageVoxels)
        refuse(where + "size: more than the " + std::to_string(kMaxImageVoxels >> 20) +
               " million voxels that are read; crop it or make its voxels larger");
}

void checkRescale(double slope, double intercept, const std::string& where, const char* slope_field,
                  const char* intercept_field) {
    if (!(slope >= kLeastSlope && slope <= kLargestSlope))
        refuse(where + slope_field + ": " + number(slope) + " makes no HU of the stored values");
    if (!(std::fabs(intercept) <= kLargestIntercept))
        refuse(where + intercept_field + ": " + number(intercept) + " makes no HU of the stored values");
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
