// NIfTI-1 files. The header is checked here before ITK reads the file.
#include <fmt/core.h>
#include <itkNiftiImageIO.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>

#include "app/modeller/image/raw_image.h"

namespace stylet::modeller {

namespace fs = std::filesystem;

namespace {

constexpr std::uint32_t kFloat = 16, kDouble = 64;  // values of the datatype field

// The first 352 bytes of a NIfTI-1 file, in either byte order. Offsets are those of nifti1.h.
class NiftiHeader {
  public:
    static constexpr std::size_t kSize = 352;
    std::array<unsigned char, kSize> bytes{};

    std::uint32_t word(std::size_t at, std::size_t size) const {
        std::uint32_t v = 0;
        for (std::size_t i = 0; i < size; ++i)
            v = v << 8 | bytes[at + (swapped() ? i : size - 1 - i)];
        return v;
    }
    double real(std::size_t at) const { return double(std::bit_cast<float>(word(at, 4))); }
    double pixdim(std::size_t d) const { return real(76 + 4 * d); }
    std::int64_t side(std::size_t d) const { return std::int16_t(word(40 + 2 * d, 2)); }
    std::string magic() const { return {bytes.begin() + 344, bytes.begin() + 347}; }

    // True if the file is big-endian. Its first four bytes are the header size, 348 = 0x0000015C, so the
    // first byte is 0 only in a big-endian file.
    bool swapped() const { return bytes[0] == 0; }
};

void checkKind(const NiftiHeader& h) {
    if (std::string(h.bytes.begin() + 128, h.bytes.begin() + 132) == "DICM")
        refuse("is one DICOM file; name the folder of its series");
    if (h.word(0, 4) == 540) refuse("is a NIfTI-2 file; save it as NIfTI-1 (.nii.gz)");
    if (h.word(0, 4) != 348) refuse("sizeof_hdr: not a NIfTI file");
    if (h.magic() == "ni1") refuse("magic: header and voxels in two files; save it as one .nii.gz");
    if (h.magic() != "n+1") refuse("magic: not a NIfTI-1 file in one piece");
}

// Refuses what ITK would replace with a guess: an unknown voxel size becomes 1 mm, NaN becomes 0.
void checkNumbers(const NiftiHeader& h, bool phase) {
    const bool has_qform = h.word(252, 2) != 0, has_sform = h.word(254, 2) != 0;
    for (std::size_t d = 1; d <= 3; ++d) {
        const double v = h.pixdim(d);
        if (!(v > 0.0 && std::isfinite(v)) && !(phase && v == 0.0))
            refuse(fmt::format("pixdim[{}]: {} is no voxel size", d, formatNumber(v)));
    }
    const auto check = [&](const std::string& field, std::size_t at, double limit) {
        const double v = h.real(at);
        if (!(std::fabs(v) < limit)) refuse(field + ": " + formatNumber(v) + " is impossible");
    };
    constexpr double kFarthest_mm = 1e5;
    for (std::size_t d = 0; d < 3; ++d) {
        const std::string axis(1, char('x' + d)), part(1, char('b' + d));
        if (has_qform) check("qoffset_" + axis, 268 + 4 * d, kFarthest_mm);
        if (has_qform) check("quatern_" + part, 256 + 4 * d, 2.0);
        if (has_sform) check("srow_" + axis + "[3]", 292 + 16 * d, kFarthest_mm);
    }
    if (has_qform && std::isnan(h.pixdim(0))) refuse("pixdim[0]: nan is neither 1 nor -1");
}

// ITK converts the spacing to millimetres, but not the position.
void checkUnits(const NiftiHeader& h) {
    const int unit = h.bytes[123] & 7;
    if (unit == 1 || unit == 3)
        refuse(fmt::format("xyzt_units: {}; write the file in mm", unit == 1 ? "metres" : "micrometres"));
}

// Checks the orientation. A CT or a segmentation without one is refused, because guessing could swap left and
// right.
void checkOrientation(const NiftiHeader& h, bool phase) {
    const bool has_qform = h.word(252, 2) != 0, has_sform = h.word(254, 2) != 0;
    if (!has_qform && !has_sform && !phase)
        refuse("qform_code and sform_code: are both 0, so left and right are unknown");
    // Without an sform, ITK reports the axes of the qform. They are checked after ITK has read the header.
    if (!has_sform || phase) return;
    for (std::size_t column = 0; column < 3; ++column) {
        double largest = 0.0, squares = 0.0;
        for (std::size_t row = 0; row < 3; ++row) {
            const double v = h.real(280 + 16 * row + 4 * column);
            largest = std::max(largest, std::fabs(v));
            squares += v * v;
        }
        const double length_mm = std::sqrt(squares), pixdim_mm = h.pixdim(column + 1);
        if (!(squares > 0.0) || !std::isfinite(squares)) refuse("srow: is no map from voxels to place");
        if (!(largest / length_mm > kMinUprightCosine))
            refuse("srow: its axes are tilted by " + formatDegrees(largest / length_mm) +
                   ", more than 5 degrees, against the patient's; resample it to upright axes");
        if (!(std::fabs(pixdim_mm - length_mm) <= 1e-3 * length_mm))
            refuse(fmt::format("pixdim[{}]: {} mm, but srow's column for that axis is {} mm long", column + 1,
                               formatNumber(pixdim_mm), formatNumber(length_mm)));
    }
}

// A file with qform and sform has two positions of its first voxel. ITK would use one without a word.
void checkPosition(const NiftiHeader& h) {
    if (h.word(252, 2) == 0 || h.word(254, 2) == 0) return;
    const double voxel_mm = std::min({h.pixdim(1), h.pixdim(2), h.pixdim(3)});
    for (std::size_t d = 0; d < 3; ++d) {
        const double qform_mm = h.real(268 + 4 * d), sform_mm = h.real(292 + 16 * d);
        if (!(std::fabs(qform_mm - sform_mm) <= 0.5 * voxel_mm))
            refuse(
                fmt::format("qoffset_{0} and srow_{0}[3]: the first voxel is at {1} mm and at {2} mm; store "
                            "one position in both, or set qform_code or sform_code to 0",
                            "xyz"[d], formatNumber(qform_mm), formatNumber(sform_mm)));
    }
}

// Returns the bytes per voxel for a value of the header's datatype field. Accepts signed and unsigned
// integers of 8, 16 and 32 bits, float and double. Refuses all other types.
std::int64_t bytesPerVoxel(std::uint32_t datatype) {
    constexpr std::pair<std::uint32_t, int> kTypes[] = {{2, 1}, {256, 1}, {4, 2},      {512, 2},
                                                        {8, 4}, {768, 4}, {kFloat, 4}, {kDouble, 8}};
    for (const auto& [type, bytes] : kTypes)
        if (type == datatype) return bytes;
    refuse(fmt::format("datatype: {} is not read; save whole numbers or floats", datatype));
}

// The size of the voxel data in bytes according to the header.
std::int64_t volumeBytes(const NiftiHeader& h) {
    std::int64_t bytes = bytesPerVoxel(h.word(70, 2));
    if (h.word(72, 2) != 8 * bytes) refuse("bitpix: does not fit the datatype");
    const std::size_t dimensions = std::min(h.word(40, 2), 7u);
    if (dimensions < 3) refuse("dim: fewer than three dimensions");
    for (std::size_t d = 1; d <= dimensions; ++d) {
        const std::int64_t side = h.side(d);
        if (d > 3 && side > 1)
            refuse(fmt::format("dim: more than three dimensions ({} volumes); save one of them alone", side));
        if (side < 1 || side > kMaxImageSide || bytes * side > 8 * kMaxImageVoxels)
            refuse(
                fmt::format("dim: a size of {} along axis {} is outside what this program reads", side, d));
        bytes *= side;
    }
    return bytes;
}

// Refuses NaN and infinity. ITK's reader would turn them into 0, which is water in HU.
void checkFinite(const NiftiHeader& h, NiftiKind kind, const unsigned char* voxels, std::size_t bytes) {
    const std::uint32_t datatype = h.word(70, 2);
    if (datatype != kFloat && datatype != kDouble) return;
    const std::size_t size = datatype == kFloat ? 4 : 8;
    const std::size_t high = h.swapped() ? 0 : size - 1, next = h.swapped() ? 1 : size - 2;
    for (std::size_t i = 0; i + size <= bytes; i += size) {
        const int exponent = (voxels[i + high] & 0x7f) << 8 | voxels[i + next];
        if (size == 4 ? (exponent & 0x7f80) == 0x7f80 : (exponent & 0x7ff0) == 0x7ff0)
            refuse(kind == NiftiKind::labels
                       ? "voxels: some are not numbers; write 0 where nothing is labelled"
                       : "voxels: some are not numbers; write -1024 where nothing was scanned");
    }
}

// ITK recognises a compressed file by its name.
void checkName(const fs::path& file, bool compressed) {
    std::string name = file.filename().string();
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
    if (compressed && name.ends_with(".nii")) refuse("name: its data is compressed by gzip; name it .nii.gz");
    if (!name.ends_with(".nii") && !name.ends_with(".nii.gz"))
        refuse("name: does not end in .nii or .nii.gz");
}

void checkScale(const NiftiHeader& h) {
    const double slope = h.real(112), intercept = h.real(116);
    if (slope != 0.0) return checkRescale(slope, intercept, "", "scl_slope", "scl_inter");
    // NIfTI-1: a slope of 0 means no scaling. ITK would add the intercept.
    if (intercept != 0.0)
        refuse(
            fmt::format("scl_inter: {}, but scl_slope is 0, which means no scaling; set both to the real "
                        "scaling, or both to 0",
                        formatNumber(intercept)));
}

// Refuses truncated files, which ITK would fill up with zeros, and headers that ITK would read as ANALYZE.
void checkNiftiFile(const fs::path& file, NiftiKind kind) {
    const bool phase = kind == NiftiKind::phase;
    const std::unique_ptr<gzFile_s, int (*)(gzFile)> in(gzopen(file.c_str(), "rb"), gzclose);
    NiftiHeader h;
    if (!in || gzread(in.get(), h.bytes.data(), unsigned(h.bytes.size())) != int(h.bytes.size()))
        refuse("not a NIfTI file: too short, damaged or not to be opened");
    checkKind(h);
    checkName(file, gzdirect(in.get()) == 0);
    checkUnits(h);
    checkNumbers(h, phase);
    checkOrientation(h, phase);
    checkPosition(h);
    checkScale(h);
    const double offset = h.real(108);
    if (!(offset >= 352.0 && offset < 1e6)) refuse("vox_offset: " + formatNumber(offset) + " is impossible");
    const std::int64_t size = volumeBytes(h);
    std::vector<unsigned char> chunk(1 << 20);
    const auto read = [&](std::int64_t count) {
        if (gzread(in.get(), chunk.data(), unsigned(count)) != int(count))
            refuse("voxels: cut short or damaged; copy the file again");
    };
    read(std::int64_t(offset) - std::int64_t(h.bytes.size()));
    for (std::int64_t at = 0; at < size; at += std::int64_t(chunk.size())) {
        const std::int64_t count = std::min(size - at, std::int64_t(chunk.size()));
        read(count);
        checkFinite(h, kind, chunk.data(), std::size_t(count));
    }
    // Try to read one byte after the voxels. At the end of a .gz file, zlib then verifies the checksum.
    // gzread() fails if the checksum is wrong. Z_BUF_ERROR means that the file was cut short.
    int state = Z_OK;
    if (gzread(in.get(), chunk.data(), 1) < 0 || (gzerror(in.get(), &state), state == Z_BUF_ERROR))
        refuse("voxels: cut short or damaged; copy the file again");
}

// ITK's own sentence, without the name of the class and its address.
std::string reason(const itk::ExceptionObject& e) {
    const std::string text = e.GetDescription();
    for (const char* before : {"): ", "ERROR: "})
        if (const std::size_t at = text.find(before); at != std::string::npos)
            return text.substr(at + std::strlen(before));
    return text;
}

}  // namespace

RawImage readNifti(const fs::path& file, NiftiKind kind) {
    checkNiftiFile(file, kind);
    auto io = itk::NiftiImageIO::New();
    io->SetFileName(file.string());
    try {
        io->ReadImageInformation();
        if (io->GetNumberOfDimensions() < 3) refuse("dim: fewer than three dimensions");
        return readVolume(*io, kind == NiftiKind::labels);
    } catch (const itk::ExceptionObject& e) {
        refuse("ITK cannot read it: " + reason(e));
    }
}

}  // namespace stylet::modeller
