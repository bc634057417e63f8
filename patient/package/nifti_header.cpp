// Field offsets after nifti1.h (Cox et al. 2004).
#include "patient/package/nifti_header.h"

#include <fmt/core.h>

#include <cmath>
#include <cstring>

#include "patient/package/nifti.h"
#include "patient/package/package.h"

namespace stylet::patient {
namespace {

constexpr std::size_t kDim = 40, kIntent = 68, kDatatype = 70, kBitpix = 72, kPixdim = 76, kVoxOffset = 108,
                      kSlope = 112, kIntercept = 116, kUnits = 123, kDescription = 148, kQformCode = 252,
                      kSformCode = 254, kQuaternion = 256, kQoffset = 268, kSrow = 280, kMagic = 344;
constexpr double kMaxOffset_mm = 10000.0;
constexpr double kMinSpacing_mm = 0.02, kMaxSpacing_mm = 50.0;
constexpr double kMaxExtensionBytes = 1 << 24;
constexpr std::int16_t kIntentVector = 1007;
constexpr std::size_t kMaxVectors = std::size_t(4) << 20;
constexpr double kMaxAxisTilt = 1e-4;  // rad; over 500 voxels this is an error of 0.05 voxels

// voxel index -> mm.
struct Orientation {
    glm::dmat3 columns{0.0};
    Vec3 offset_mm{0.0};
};

class HeaderReader {
  public:
    HeaderReader(const std::filesystem::path& file, std::span<const std::byte, kNiftiHeaderBytes> bytes)
        : file_(file), bytes_(bytes) {
        if (integer<std::int32_t>(0) == int(kNiftiHeaderBytes)) return;
        big_endian_ = true;
        if (integer<std::int32_t>(0) == int(kNiftiHeaderBytes)) return;
        refuse("sizeof_hdr", "not 348 in either byte order: not NIfTI-1");
    }

    [[noreturn]] void refuse(const std::string& field, const std::string& reason) const {
        throw DataError(file_, field, reason);
    }
    [[noreturn]] void refuseValue(const std::string& field, double value, const std::string& reason) const {
        refuse(field, fmt::format("{:g} {}", value, reason));
    }

    template <typename Int>
    Int integer(std::size_t at) const {
        std::make_unsigned_t<Int> value = 0;
        for (std::size_t i = 0; i < sizeof(Int); ++i) {
            const std::size_t byte = big_endian_ ? i : sizeof(Int) - 1 - i;
            value =
                std::make_unsigned_t<Int>((value << 8) | std::to_integer<std::uint8_t>(bytes_[at + byte]));
        }
        return static_cast<Int>(value);
    }
    double number(const std::string& field, std::size_t at) const {
        const double value = double(std::bit_cast<float>(integer<std::uint32_t>(at)));
        if (!std::isfinite(value)) refuse(field, "not finite");
        return value;
    }
    bool bigEndian() const { return big_endian_; }

    void checkMagic() const {
        if (std::memcmp(bytes_.data() + kMagic, "ni1", 4) == 0)
            refuse("magic", "a .hdr/.img pair; one file is needed");
        if (std::memcmp(bytes_.data() + kMagic, "n+1", 4) != 0) refuse("magic", "not \"n+1\"");
    }
    Index3 dims(int components) const {
        const int rank = integer<std::int16_t>(kDim);
        if (rank < 3 || rank > 7) refuseValue("dim[0]", rank, "is not the rank of a volume");
        std::array<int, 8> dim{};
        for (int i = 1; i <= rank; ++i) {
            dim[std::size_t(i)] = integer<std::int16_t>(kDim + 2 * std::size_t(i));
            const int limit = i <= 3 ? kMaxVoxelsPerSide : i == 5 ? components : 1;
            if (dim[std::size_t(i)] < 1 || dim[std::size_t(i)] > limit)
                refuseValue(fmt::format("dim[{}]", i), dim[std::size_t(i)],
                            fmt::format("is not in [1, {}]", limit));
        }
        if (components > 1 && dim[5] != components)
            refuseValue("dim[5]", dim[5], fmt::format("is not {}", components));
        const Grid grid{{dim[1], dim[2], dim[3]}};
        if (grid.voxelCount() > kMaxVoxels) refuse("dim", "more than 512 Mi voxels");
        if (components > 1 && grid.voxelCount() > kMaxVectors) refuse("dim", "more than 4 Mi vectors");
        return grid.dims;
    }
    NiftiType type() const {
        const std::int16_t code = integer<std::int16_t>(kDatatype), bitpix = integer<std::int16_t>(kBitpix);
        for (const NiftiType& type : kNiftiTypes) {
            if (code != type.code) continue;
            if (bitpix != int(8 * type.bytes)) refuseValue("bitpix", bitpix, "does not fit the datatype");
            return type;
        }
        refuseValue("datatype", code, "is not supported; 2, 4, 8, 16, 64 and 512 are");
    }
    std::size_t dataOffset() const {
        const double offset = number("vox_offset", kVoxOffset);
        if (offset < double(kNiftiDataOffset) || offset > kMaxExtensionBytes || offset != std::floor(offset))
            refuseValue("vox_offset", offset, "is not an offset behind the header");
        return std::size_t(offset);
    }
    Orientation orientation(const Index3& dims) const {
        const bool has_sform = integer<std::int16_t>(kSformCode) > 0,
                   has_qform = integer<std::int16_t>(kQformCode) > 0;
        if (!has_sform && !has_qform)
            refuse("sform_code", "neither sform nor qform is set, so the orientation is unknown");
        const Orientation o = has_sform ? sform() : qform();
        if (has_sform && has_qform) {
            const Orientation other = qform();
            for (int corner = 0; corner < 8; ++corner) {
                const Vec3 at = Vec3(dims - 1) * Vec3(corner & 1, (corner >> 1) & 1, (corner >> 2) & 1);
                if (glm::length(o.columns * at + o.offset_mm - other.columns * at - other.offset_mm) > 1.0)
                    refuse("sform", "more than 1 mm away from qform");
            }
        }
        return o;
    }

  private:
    Orientation sform() const {
        Orientation o;
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column)
                o.columns[column][row] =
                    number("srow", kSrow + 16 * std::size_t(row) + 4 * std::size_t(column));
            o.offset_mm[row] = number("srow", kSrow + 16 * std::size_t(row) + 12);
        }
        return o;
    }
    Orientation qform() const {
        const Vec3 q{number("quatern_b", kQuaternion), number("quatern_c", kQuaternion + 4),
                     number("quatern_d", kQuaternion + 8)};
        const double squared = glm::dot(q, q);
        if (squared > 1.0 + 1e-5) refuse("quatern", "longer than 1");
        const glm::dmat3 turn = glm::mat3_cast(Quat(std::sqrt(std::max(0.0, 1.0 - squared)), q.x, q.y, q.z));
        Orientation o;
        for (int axis = 0; axis < 3; ++axis) {
            const std::size_t at = std::size_t(axis);
            o.columns[axis] = turn[axis] * number("pixdim", kPixdim + 4 * (at + 1));
            o.offset_mm[axis] = number("qoffset", kQoffset + 4 * at);
        }
        if (number("pixdim[0]", kPixdim) < 0.0) o.columns[2] = -o.columns[2];
        return o;
    }

    const std::filesystem::path& file_;
    std::span<const std::byte, kNiftiHeaderBytes> bytes_;
    bool big_endian_ = false;
};

void setGrid(NiftiHeader& header, const HeaderReader& in, int components) {
    const Index3 dims = in.dims(components);
    const Orientation o = in.orientation(dims);
    header.grid.dims = dims;
    for (int axis = 0; axis < 3; ++axis) {
        const double along = o.columns[axis][axis];
        const double spacing_mm = std::abs(along);
        for (int other = 0; other < 3; ++other)
            if (other != axis && std::abs(o.columns[axis][other]) > kMaxAxisTilt * spacing_mm)
                in.refuse("sform", "oblique or permuted: axes must run along the patient's");
        if (!(spacing_mm >= kMinSpacing_mm && spacing_mm <= kMaxSpacing_mm))
            in.refuseValue("spacing", spacing_mm, "mm is not in [0.02, 50]");
        if (std::abs(o.offset_mm[axis]) > kMaxOffset_mm)
            in.refuseValue("offset", o.offset_mm[axis], "mm is too far away");
        header.flipped[std::size_t(axis)] = along < 0.0;
        const double first_mm = o.offset_mm[axis] + (along < 0.0 ? along * (dims[axis] - 1) : 0.0);
        header.grid.spacing_m[axis] = spacing_mm / 1000.0;
        header.grid.origin_m[axis] = first_mm / 1000.0;
    }
}

void setScale(NiftiHeader& header, const HeaderReader& in) {
    const double slope = in.number("scl_slope", kSlope), intercept = in.number("scl_inter", kIntercept);
    if (std::abs(slope) > 1e6 || std::abs(intercept) > 1e6) in.refuse("scl_slope", "beyond 1e6");
    // Zero means "no scaling" in NIfTI.
    if (slope != 0.0) header.slope = slope, header.intercept = intercept;
}

template <typename Value>
void put(NiftiHeaderBytes& bytes, std::size_t at, Value value) {
    static_assert(std::endian::native == std::endian::little);
    std::memcpy(bytes.data() + at, &value, sizeof(Value));
}

}  // namespace

NiftiHeader parseNiftiHeader(const std::filesystem::path& file,
                             std::span<const std::byte, kNiftiHeaderBytes> bytes, int components) {
    const HeaderReader in(file, bytes);
    in.checkMagic();
    NiftiHeader header;
    header.big_endian = in.bigEndian();
    header.type = in.type();
    header.data_offset = in.dataOffset();
    const int length_unit = std::to_integer<int>(bytes[kUnits]) & 7;
    if (length_unit != 0 && length_unit != 2) in.refuseValue("xyzt_units", length_unit, "is not mm");
    setScale(header, in);
    setGrid(header, in, components);
    return header;
}

NiftiHeaderBytes makeNiftiHeader(const NiftiType& type, const Grid& grid, int components) {
    NiftiHeaderBytes bytes{};
    put(bytes, 0, std::int32_t(kNiftiHeaderBytes));
    for (std::size_t i = 0; i < 8; ++i)
        put(bytes, kDim + 2 * i, std::int16_t(1));
    put(bytes, kDim, std::int16_t(components > 1 ? 5 : 3));
    put(bytes, kDim + 10, std::int16_t(components));
    if (components > 1) put(bytes, kIntent, kIntentVector);
    put(bytes, kDatatype, type.code);
    put(bytes, kBitpix, std::int16_t(8 * type.bytes));
    put(bytes, kPixdim, 1.0f);
    put(bytes, kVoxOffset, float(kNiftiDataOffset));
    put(bytes, kSlope, 1.0f);
    put(bytes, kUnits, std::uint8_t(2));
    std::memcpy(bytes.data() + kDescription, "Stylet", 6);
    put(bytes, kQformCode, std::int16_t(1));
    put(bytes, kSformCode, std::int16_t(1));
    for (int axis = 0; axis < 3; ++axis) {
        const std::size_t at = std::size_t(axis);
        const float spacing_mm = float(grid.spacing_m[axis] * 1000.0),
                    origin_mm = float(grid.origin_m[axis] * 1000.0);
        put(bytes, kDim + 2 * (at + 1), std::int16_t(grid.dims[axis]));
        put(bytes, kPixdim + 4 * (at + 1), spacing_mm);
        put(bytes, kQoffset + 4 * at, origin_mm);
        put(bytes, kSrow + 16 * at + 4 * at, spacing_mm);
        put(bytes, kSrow + 16 * at + 12, origin_mm);
    }
    std::memcpy(bytes.data() + kMagic, "n+1", 4);
    return bytes;
}

}  // namespace stylet::patient
