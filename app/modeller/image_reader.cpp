// stylet-image-reader ct|labels|phase PATH OUT: reads a hospital image with ITK, in a process of its own,
// because the parsers underneath were not made for hostile files. The parent sets the limits
// (image_import.cpp), takes the voxels from OUT and, if this program gives up, its one sentence from standard
// output.
#include <itkGDCMImageIO.h>
#include <itkMetaDataObject.h>
#include <itkNiftiImageIO.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/modeller/image_handover.h"

namespace fs = std::filesystem;
using stylet::modeller::ImageHandover;
using stylet::modeller::kMaxImageSide;
using stylet::modeller::kMaxImageVoxels;

namespace {

using V3 = std::array<double, 3>;

double dot(const V3& a, const V3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
V3 cross(const V3& a, const V3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
std::string number(double v) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", v);
    return text;
}
[[noreturn]] void refuse(const std::string& sentence) {
    throw std::runtime_error(sentence);
}

// Voxels as stored, with the frame ITK reports: LPS, millimetres.
struct RawImage {
    std::array<std::int64_t, 3> dims{};
    V3 spacing{}, origin{};
    std::array<V3, 3> axes{};  // unit vectors of i, j, k
    std::vector<std::int16_t> voxels;
};

void checkDims(const std::array<std::int64_t, 3>& dims, const std::string& name) {
    for (std::int64_t d : dims)
        if (d < 1 || d > kMaxImageSide)
            refuse(name + ": a side of " + std::to_string(d) + " voxels is outside 1 to " +
                   std::to_string(kMaxImageSide));
    if (dims[0] * dims[1] * dims[2] > kMaxImageVoxels) refuse(name + ": more voxels than this program reads");
}

template <typename T>
void toInt16(const std::vector<char>& bytes, bool labels, const std::string& name, std::int16_t* out,
             std::size_t count) {
    const T* in = reinterpret_cast<const T*>(bytes.data());
    for (std::size_t i = 0; i < count; ++i) {
        const double v = double(in[i]);
        if (labels && !(v >= 0.0 && v <= 32767.0 && v == std::floor(v)))
            refuse(name + ": a label of " + number(v) + " is not a whole number from 0 to 32767");
        if (!std::isfinite(v)) refuse(name + ": holds a value that is not a number");
        out[i] = std::int16_t(std::lround(std::clamp(v, -32768.0, 32767.0)));
    }
}

// Reads the pixels of an ImageIO whose information has been read.
void readVoxels(itk::ImageIOBase& io, bool labels, const std::string& name, std::int16_t* out,
                std::size_t count) {
    if (io.GetNumberOfComponents() != 1)
        refuse(name + ": a colour picture, not a CT slice or a label volume");
    if (std::size_t(io.GetImageSizeInPixels()) != count)
        refuse(name + ": its size disagrees with its header");
    itk::ImageIORegion region(io.GetNumberOfDimensions());
    for (unsigned d = 0; d < io.GetNumberOfDimensions(); ++d)
        region.SetSize(d, io.GetDimensions(d));
    io.SetIORegion(region);
    std::vector<char> bytes(std::size_t(io.GetImageSizeInBytes()));
    io.Read(bytes.data());
    using Type = itk::CommonEnums::IOComponent;
    switch (io.GetComponentType()) {
        case Type::UCHAR:
            return toInt16<unsigned char>(bytes, labels, name, out, count);
        case Type::CHAR:
            return toInt16<signed char>(bytes, labels, name, out, count);
        case Type::USHORT:
            return toInt16<unsigned short>(bytes, labels, name, out, count);
        case Type::SHORT:
            return toInt16<short>(bytes, labels, name, out, count);
        case Type::UINT:
            return toInt16<unsigned int>(bytes, labels, name, out, count);
        case Type::INT:
            return toInt16<int>(bytes, labels, name, out, count);
        case Type::FLOAT:
            return toInt16<float>(bytes, labels, name, out, count);
        case Type::DOUBLE:
            return toInt16<double>(bytes, labels, name, out, count);
        default:
            refuse(name + ": voxels of a type this program does not read");
    }
}

V3 axis(const itk::ImageIOBase& io, unsigned i) {
    const std::vector<double> d = io.GetDirection(i);
    return d.size() == 3 ? V3{d[0], d[1], d[2]} : V3{0.0, 0.0, 0.0};
}

// One DICOM file's place, before its pixels are wanted.
struct Slice {
    fs::path file;
    std::array<std::int64_t, 3> dims{};
    V3 spacing{}, origin{}, row{}, column{};
    std::string series, modality;
    double along = 0.0;  // position along the stack's normal, mm
};

bool looksLikeDicom(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    char head[132] = {};
    return in.read(head, sizeof head) && std::string(head + 128, 4) == "DICM";
}

Slice readSliceHeader(const fs::path& file) {
    auto io = itk::GDCMImageIO::New();
    io->SetFileName(file.string());
    io->SetMaxSizeLoadEntry(4096);
    const std::string name = file.filename().string();
    try {
        io->ReadImageInformation();
    } catch (const itk::ExceptionObject&) {
        refuse(name + ": not a readable DICOM slice (damaged or cut short)");
    }
    Slice s;
    s.file = file;
    for (unsigned d = 0; d < 3; ++d) {
        s.dims[d] = d < io->GetNumberOfDimensions() ? std::int64_t(io->GetDimensions(d)) : 1;
        s.spacing[d] = d < io->GetNumberOfDimensions() ? io->GetSpacing(d) : 1.0;
        s.origin[d] = d < io->GetNumberOfDimensions() ? io->GetOrigin(d) : 0.0;
    }
    checkDims(s.dims, name);
    if (s.dims[2] != 1) refuse(name + ": holds several frames; export it as one file per slice, or as NIfTI");
    s.row = axis(*io, 0);
    s.column = axis(*io, 1);
    const auto& tags = io->GetMetaDataDictionary();
    std::string position;
    if (!itk::ExposeMetaData<std::string>(tags, "0020|0032", position))
        refuse(name + ": has no image position, so its place in the patient is unknown");
    itk::ExposeMetaData<std::string>(tags, "0020|000e", s.series);
    itk::ExposeMetaData<std::string>(tags, "0008|0060", s.modality);
    while (!s.modality.empty() && (s.modality.back() == ' ' || s.modality.back() == '\0'))
        s.modality.pop_back();
    return s;
}

std::vector<Slice> readHeaders(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        if (!entry.is_regular_file() || entry.path().filename() == "DICOMDIR") continue;
        files.push_back(entry.path());
        if (files.size() > 10000) refuse("the folder holds more than 10,000 files");
    }
    std::sort(files.begin(), files.end());
    std::vector<Slice> slices;
    for (const fs::path& file : files)
        if (looksLikeDicom(file)) slices.push_back(readSliceHeader(file));
    if (slices.empty()) refuse("no DICOM slice among its " + std::to_string(files.size()) + " files");
    return slices;
}

void checkOneSeries(const std::vector<Slice>& slices) {
    std::map<std::string, int> count;
    for (const Slice& s : slices)
        ++count[s.series];
    if (count.size() > 1) {
        std::string sizes;
        for (const auto& [uid, n] : count)
            sizes += (sizes.empty() ? "" : ", ") + std::to_string(n);
        refuse("holds " + std::to_string(count.size()) + " series (of " + sizes +
               " slices); put the one to import into a folder of its own");
    }
    const Slice& first = slices.front();
    for (const Slice& s : slices) {
        const std::string name = s.file.filename().string();
        if (!s.modality.empty() && s.modality != "CT") refuse(name + ": modality " + s.modality + ", not CT");
        if (s.dims != first.dims || std::fabs(s.spacing[0] - first.spacing[0]) > 1e-3 ||
            std::fabs(s.spacing[1] - first.spacing[1]) > 1e-3)
            refuse(name + ": its size or pixel spacing differs from the other slices'");
        if (dot(s.row, first.row) < 0.9999 || dot(s.column, first.column) < 0.9999)
            refuse(name + ": lies at another angle than the other slices");
    }
}

// Orders the slices along their normal and returns the spacing; a hole or a double is refused by name.
double orderSlices(std::vector<Slice>& slices) {
    const V3 normal = cross(slices.front().row, slices.front().column);
    for (Slice& s : slices)
        s.along = dot(s.origin, normal);
    std::sort(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) { return a.along < b.along; });
    if (slices.size() < 3) refuse("only " + std::to_string(slices.size()) + " slices; a volume needs three");
    std::vector<double> gaps;
    for (std::size_t i = 1; i < slices.size(); ++i)
        gaps.push_back(slices[i].along - slices[i - 1].along);
    std::vector<double> sorted = gaps;
    std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2), sorted.end());
    const double usual = sorted[sorted.size() / 2];
    for (std::size_t i = 0; i < gaps.size(); ++i) {
        const std::string pair =
            slices[i].file.filename().string() + " and " + slices[i + 1].file.filename().string();
        if (gaps[i] < 0.05 || gaps[i] < 0.5 * usual) refuse(pair + " lie in the same place");
        if (gaps[i] > 1.5 * usual)
            refuse("slices are missing between " + pair + ": a gap of " + number(gaps[i]) + " mm where " +
                   number(usual) + " mm is usual");
        if (std::fabs(gaps[i] - usual) > 0.1 * usual)
            refuse("the slice spacing is uneven: " + number(gaps[i]) + " mm between " + pair + ", usually " +
                   number(usual) + " mm");
    }
    const Slice &first = slices.front(), &last = slices.back();
    const V3 run{last.origin[0] - first.origin[0], last.origin[1] - first.origin[1],
                 last.origin[2] - first.origin[2]};
    const double rise = dot(run, normal);
    if (std::sqrt(std::max(0.0, dot(run, run) - rise * rise)) > 2.0)
        refuse("the slices are sheared (a tilted gantry); resample the series to upright slices first");
    return rise / double(slices.size() - 1);
}

RawImage readDicomFolder(const fs::path& folder) {
    std::vector<Slice> slices = readHeaders(folder);
    checkOneSeries(slices);
    const double spacing = orderSlices(slices);
    const Slice& first = slices.front();
    RawImage image;
    image.dims = {first.dims[0], first.dims[1], std::int64_t(slices.size())};
    checkDims(image.dims, folder.filename().string());
    image.spacing = {first.spacing[0], first.spacing[1], spacing};
    image.origin = first.origin;
    image.axes = {first.row, first.column, cross(first.row, first.column)};
    const std::size_t per_slice = std::size_t(image.dims[0] * image.dims[1]);
    image.voxels.resize(per_slice * slices.size());
    for (std::size_t i = 0; i < slices.size(); ++i) {
        const std::string name = slices[i].file.filename().string();
        auto io = itk::GDCMImageIO::New();  // applies slope and intercept
        io->SetFileName(slices[i].file.string());
        try {
            io->ReadImageInformation();
            readVoxels(*io, false, name, image.voxels.data() + i * per_slice, per_slice);
        } catch (const itk::ExceptionObject&) {
            refuse(name + ": its pixels cannot be read (damaged or cut short)");
        }
    }
    return image;
}

// One phase of a 4D CT as one DICOM file of many frames. Such exports often name neither place nor spacing:
// slices are then taken to be axial, from head to feet, and what ITK supposes (1 mm) holds for the spacing.
RawImage readDicomFrames(const fs::path& file) {
    const std::string name = file.filename().string();
    auto io = itk::GDCMImageIO::New();
    io->SetFileName(file.string());
    io->SetMaxSizeLoadEntry(4096);
    RawImage image;
    try {
        io->ReadImageInformation();
        if (io->GetNumberOfDimensions() != 3 || io->GetDimensions(2) < 3)
            refuse(name + ": a single slice; a phase is one volume");
        for (unsigned d = 0; d < 3; ++d) {
            image.dims[d] = std::int64_t(io->GetDimensions(d));
            image.spacing[d] = io->GetSpacing(d);
            image.origin[d] = io->GetOrigin(d);
            image.axes[d] = axis(*io, d);
        }
        checkDims(image.dims, name);
        std::string position;
        if (!itk::ExposeMetaData<std::string>(io->GetMetaDataDictionary(), "0020|0032", position)) {
            image.origin = {0.0, 0.0, 0.0};
            image.axes = {V3{1.0, 0.0, 0.0}, V3{0.0, 1.0, 0.0}, V3{0.0, 0.0, -1.0}};
        }
        image.voxels.resize(std::size_t(image.dims[0] * image.dims[1] * image.dims[2]));
        readVoxels(*io, false, name, image.voxels.data(), image.voxels.size());
    } catch (const itk::ExceptionObject&) {
        refuse(name + ": not a readable DICOM volume (damaged or cut short)");
    }
    return image;
}

// ITK fills up a file that is cut short with zeros and takes any header for ANALYZE: both are refused here.
void checkNiftiFile(const fs::path& file, const std::string& name) {
    const std::unique_ptr<gzFile_s, int (*)(gzFile)> in(gzopen(file.c_str(), "rb"), gzclose);
    std::array<unsigned char, 352> head{};
    if (!in || gzread(in.get(), head.data(), unsigned(head.size())) != int(head.size()))
        refuse(name + ": not a NIfTI file");
    const bool swapped = head[0] == 0;  // the header begins with its size, 348
    const auto field = [&](std::size_t at, std::size_t size) {
        std::uint32_t v = 0;
        for (std::size_t i = 0; i < size; ++i)
            v = v << 8 | head[at + (swapped ? i : size - 1 - i)];
        return v;
    };
    if (field(0, 4) != 348 || std::string(head.begin() + 344, head.begin() + 347) != "n+1")
        refuse(name + ": not a NIfTI-1 file in one piece");
    std::int64_t needed = field(72, 2) / 8;
    for (std::size_t d = 1; d <= std::min(field(40, 2), 7u); ++d) {
        const auto side = std::int64_t(std::int16_t(field(40 + 2 * d, 2)));
        if (side < 1 || side > kMaxImageSide || needed * side > 8 * kMaxImageVoxels)
            refuse(name + ": its size is outside what this program reads");
        needed *= side;
    }
    const float offset = std::bit_cast<float>(field(108, 4));
    if (!(offset >= 352.0f && offset < 1e6f)) refuse(name + ": its voxels begin in an impossible place");
    needed += std::int64_t(offset) - std::int64_t(head.size());
    std::vector<char> chunk(1 << 20);
    while (needed > 0) {
        const int got = gzread(in.get(), chunk.data(), unsigned(std::min<std::int64_t>(needed, 1 << 20)));
        if (got <= 0) refuse(name + ": cut short");
        needed -= got;
    }
}

RawImage readNifti(const fs::path& file, bool labels) {
    const std::string name = file.filename().string();
    checkNiftiFile(file, name);
    auto io = itk::NiftiImageIO::New();
    io->SetFileName(file.string());
    RawImage image;
    try {
        io->ReadImageInformation();
        for (unsigned d = 3; d < io->GetNumberOfDimensions(); ++d)
            if (io->GetDimensions(d) != 1) refuse(name + ": has more than three dimensions");
        if (io->GetNumberOfDimensions() < 3) refuse(name + ": has fewer than three dimensions");
        for (unsigned d = 0; d < 3; ++d) {
            image.dims[d] = std::int64_t(io->GetDimensions(d));
            image.spacing[d] = io->GetSpacing(d);
            image.origin[d] = io->GetOrigin(d);
            const std::vector<double> direction = io->GetDirection(d);
            image.axes[d] = {direction.at(0), direction.at(1), direction.at(2)};
        }
        checkDims(image.dims, name);
        image.voxels.resize(std::size_t(image.dims[0] * image.dims[1] * image.dims[2]));
        readVoxels(*io, labels, name, image.voxels.data(), image.voxels.size());
    } catch (const itk::ExceptionObject&) {
        refuse(name + ": not a readable NIfTI file (damaged or cut short)");
    }
    return image;
}

// Turns the stored axes into right, anterior, superior by swapping and flipping, never by interpolating.
ImageHandover toRas(const RawImage& in, std::vector<std::int16_t>& out) {
    ImageHandover header;
    std::array<int, 3> source{-1, -1, -1};  // of each RAS axis
    std::array<bool, 3> flip{};
    V3 corner = in.origin;
    for (int i = 0; i < 3; ++i) {
        if (!(in.spacing[i] >= 0.05 && in.spacing[i] <= 20.0))
            refuse("a voxel spacing of " + number(in.spacing[i]) + " mm is outside 0.05 to 20 mm");
        int along = 0;
        for (int d = 1; d < 3; ++d)
            if (std::fabs(in.axes[i][d]) > std::fabs(in.axes[i][along])) along = d;
        if (!(std::fabs(in.axes[i][along]) > 0.996) || source[along] != -1)
            refuse("its axes are tilted by more than 5 degrees against the patient's; straighten it first");
        source[along] = i;
        const bool ras_sign_flips = along < 2;  // LPS to RAS
        flip[along] = (in.axes[i][along] > 0.0) == ras_sign_flips;
        if (flip[along])
            for (int d = 0; d < 3; ++d)
                corner[d] += in.axes[i][d] * in.spacing[i] * double(in.dims[i] - 1);
    }
    for (int d = 0; d < 3; ++d) {
        header.dims[d] = in.dims[source[d]];
        header.spacing_mm[d] = in.spacing[source[d]];
        header.origin_mm[d] = d < 2 ? -corner[d] : corner[d];
        if (!(std::fabs(corner[d]) < 1e5)) refuse("its origin lies absurdly far away");
    }
    const std::array<std::int64_t, 3> in_stride{1, in.dims[0], in.dims[0] * in.dims[1]};
    std::array<std::int64_t, 3> step{};
    std::int64_t start = 0;
    for (int d = 0; d < 3; ++d) {
        step[d] = flip[d] ? -in_stride[source[d]] : in_stride[source[d]];
        if (flip[d]) start += in_stride[source[d]] * (header.dims[d] - 1);
    }
    out.reserve(in.voxels.size());
    for (std::int64_t z = 0; z < header.dims[2]; ++z)
        for (std::int64_t y = 0; y < header.dims[1]; ++y)
            for (std::int64_t x = 0; x < header.dims[0]; ++x)
                out.push_back(in.voxels[std::size_t(start + x * step[0] + y * step[1] + z * step[2])]);
    return header;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::puts("usage: stylet-image-reader ct|labels|phase PATH OUT");
        return 2;
    }
    try {
        itk::Object::GlobalWarningDisplayOff();
        const std::string kind = argv[1];
        const fs::path path(argv[2]);
        const bool frames = kind == "phase" && !fs::is_directory(path) && looksLikeDicom(path);
        const RawImage image = fs::is_directory(path) ? readDicomFolder(path)
                               : frames               ? readDicomFrames(path)
                                                      : readNifti(path, kind == "labels");
        std::vector<std::int16_t> voxels;
        const ImageHandover header = toRas(image, voxels);
        std::ofstream out(argv[3], std::ios::binary);
        out.write(reinterpret_cast<const char*>(&header), sizeof header);
        out.write(reinterpret_cast<const char*>(voxels.data()),
                  std::streamsize(voxels.size() * sizeof voxels[0]));
        if (!out.flush()) refuse("no room to hand the voxels over");
        return 0;
    } catch (const std::bad_alloc&) {
        std::puts("wants more memory than the reader is given");
    } catch (const std::exception& e) {
        std::puts(e.what());
    }
    return 1;
}
