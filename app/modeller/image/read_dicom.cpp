// Reads a DICOM series: finds the slices, checks that none is missing or misplaced, and reads their voxels.
#include <itkGDCMImageIO.h>
#include <itkMetaDataObject.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <optional>
#include <string_view>

#include "app/modeller/image/raw_image.h"
#include "base/statistics.h"

namespace stylet::modeller {

namespace fs = std::filesystem;

namespace {

// The DICOM tags named in error messages.
constexpr const char *kModality = "Modality (0008,0060)", *kPosition = "ImagePositionPatient (0020,0032)",
                     *kOrientation = "ImageOrientationPatient (0020,0037)",
                     *kPixelSpacing = "PixelSpacing (0028,0030)", *kFrames = "NumberOfFrames (0028,0008)",
                     *kIntercept = "RescaleIntercept (0028,1052)", *kSlope = "RescaleSlope (0028,1053)",
                     *kSyntax = "TransferSyntaxUID (0002,0010)";
constexpr double kSamePosition_mm = 0.05;
// Largest accepted sideways offset between the first and the last slice. The scanner's table causes smaller
// offsets.
constexpr double kShear_mm = 2.0;
constexpr std::size_t kMaxListed = 6;

double dot(const V3& a, const V3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
V3 cross(const V3& a, const V3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
// Fields of the meta header, which is always encoded as explicit little endian.
struct FileMeta {
    std::string sop_class, syntax;
};

// Returns nothing if the file is not a DICOM file.
std::optional<FileMeta> readFileMeta(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::array<char, 2048> head{};
    in.read(head.data(), head.size());
    const std::string_view bytes(head.data(), std::size_t(in.gcount()));
    if (bytes.size() < 132 || bytes.substr(128, 4) != "DICM") return {};
    const auto word = [&](std::size_t at) {
        return std::size_t(std::uint8_t(bytes[at])) | std::size_t(std::uint8_t(bytes[at + 1])) << 8;
    };
    FileMeta meta;
    for (std::size_t at = 132; at + 12 <= bytes.size() && word(at) == 2;) {
        const bool wide = bytes.substr(at + 4, 2) == "OB" || bytes.substr(at + 4, 2) == "UN";
        const std::size_t begin = at + (wide ? 12 : 8);
        const std::size_t size = wide ? word(at + 8) | word(at + 10) << 16 : word(at + 6);
        if (size > bytes.size() - begin) break;
        std::string value(bytes.substr(begin, size));
        while (!value.empty() && (value.back() == '\0' || value.back() == ' '))
            value.pop_back();
        if (word(at + 2) == 0x0002) meta.sop_class = value;
        if (word(at + 2) == 0x0010) meta.syntax = value;
        at = begin + size;
    }
    return meta;
}

// Exported studies also contain reports, presentation states, plans and documents; these are not images.
bool isImage(const FileMeta& meta) {
    for (const char* other : {"11.", "66", "88.", "104.", "481."})
        if (meta.sop_class.starts_with("1.2.840.10008.5.1.4.1.1." + std::string(other))) return false;
    return true;
}

[[noreturn]] void refuseUnreadable(const std::string& where, const FileMeta& meta, const char* part) {
    refuse(where + part + " cannot be read: damaged, cut short, or stored in a way that is not read (" +
           kSyntax + " is " + (meta.syntax.empty() ? "missing" : meta.syntax) +
           "); export it again, uncompressed");
}

std::string readTag(const itk::MetaDataDictionary& tags, const char* key) {
    std::string value;
    itk::ExposeMetaData<std::string>(tags, key, value);
    while (!value.empty() && (value.back() == ' ' || value.back() == '\0'))
        value.pop_back();
    return value;
}

// The first value of a decimal string.
double parseDecimal(const std::string& text) {
    char* end = nullptr;
    const double v = std::strtod(text.c_str(), &end);
    return end == text.c_str() ? std::nan("") : v;
}

// Header of one DICOM slice, read before its pixels.
struct Slice {
    fs::path file;
    FileMeta meta;
    std::array<std::int64_t, 3> dims{};
    V3 spacing{}, origin{}, row{}, column{};
    std::string series, modality, description;
    std::string position, orientation, pixel_spacing, slope, intercept;  // as stored
    double along = 0.0;  // position along the stack's normal, mm

    std::string name() const { return file.filename().string(); }
};

Slice readSliceHeader(const fs::path& file, const FileMeta& meta) {
    auto io = itk::GDCMImageIO::New();
    io->SetFileName(file.string());
    io->SetMaxSizeLoadEntry(4096);
    Slice s;
    s.file = file;
    s.meta = meta;
    try {
        io->ReadImageInformation();
    } catch (const itk::ExceptionObject&) {
        refuseUnreadable(s.name() + ": ", meta, "its header");
    }
    for (unsigned d = 0; d < 3; ++d) {
        s.dims[d] = d < io->GetNumberOfDimensions() ? std::int64_t(io->GetDimensions(d)) : 1;
        s.spacing[d] = d < io->GetNumberOfDimensions() ? io->GetSpacing(d) : 1.0;
        s.origin[d] = d < io->GetNumberOfDimensions() ? io->GetOrigin(d) : 0.0;
    }
    s.row = readAxis(*io, 0);
    s.column = readAxis(*io, 1);
    const auto& tags = io->GetMetaDataDictionary();
    s.series = readTag(tags, "0020|000e");
    s.modality = readTag(tags, "0008|0060");
    s.description = readTag(tags, "0008|103e");
    s.position = readTag(tags, "0020|0032");
    s.orientation = readTag(tags, "0020|0037");
    s.pixel_spacing = readTag(tags, "0028|0030");
    s.intercept = readTag(tags, "0028|1052");
    s.slope = readTag(tags, "0028|1053");
    return s;
}

std::vector<Slice> readHeaders(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        if (!entry.is_regular_file() || entry.path().filename() == "DICOMDIR") continue;
        files.push_back(entry.path());
        if (files.size() > 10000) refuse("the folder holds more than 10,000 files; name one series' folder");
    }
    std::sort(files.begin(), files.end());
    std::vector<Slice> slices;
    for (const fs::path& file : files)
        if (const std::optional<FileMeta> meta = readFileMeta(file); meta && isImage(*meta))
            slices.push_back(readSliceHeader(file, *meta));
    if (slices.empty())
        refuse("no DICOM slice among its " + std::to_string(files.size()) +
               " files; name the folder of a CT series, or a NIfTI file");
    return slices;
}

struct Series {
    std::string uid, modality, description;
    std::size_t slices = 0;
};

// Returns the series, sorted by number of slices, largest first.
std::vector<Series> listSeries(const std::vector<Slice>& slices) {
    std::map<std::string, Series> by_uid;
    for (const Slice& s : slices) {
        Series& series = by_uid[s.series];
        if (series.slices++ == 0)
            series.uid = s.series, series.modality = s.modality, series.description = s.description;
    }
    std::vector<Series> all;
    for (const auto& [uid, series] : by_uid)
        all.push_back(series);
    std::stable_sort(all.begin(), all.end(),
                     [](const Series& a, const Series& b) { return a.slices > b.slices; });
    return all;
}

std::string formatSeriesList(const std::vector<Series>& all) {
    std::string text;
    for (std::size_t i = 0; i < std::min(all.size(), kMaxListed); ++i) {
        const Series& s = all[i];
        text += (i == 0 ? "" : ", ") + (s.uid.empty() ? "(no UID)" : s.uid) + " (" +
                (s.modality.empty() ? "" : s.modality + ", ") + std::to_string(s.slices) +
                (s.slices == 1 ? " slice" : " slices") +
                (s.description.empty() ? "" : ", \"" + s.description.substr(0, 40) + "\"") + ")";
    }
    if (all.size() > kMaxListed) text += " and " + std::to_string(all.size() - kMaxListed) + " more";
    return text;
}

// Removes the slices of all series but `wanted` (a series UID). Without `wanted`, refuses slices of more than
// one series.
void selectSeries(std::vector<Slice>& slices, const std::string& wanted) {
    const std::vector<Series> all = listSeries(slices);
    if (wanted.empty()) {
        if (all.size() > 1)
            refuse("holds " + std::to_string(all.size()) +
                   " series; choose one with --series UID, or put it into a folder of its own: " +
                   formatSeriesList(all));
        return;
    }
    std::erase_if(slices, [&](const Slice& s) { return s.series != wanted; });
    if (slices.empty())
        refuse("holds no series \"" + wanted.substr(0, 64) + "\"; it holds " + formatSeriesList(all));
}

void checkSlice(const Slice& s) {
    const std::string where = s.name() + ": ";
    if (!s.modality.empty() && s.modality != "CT")
        refuse(where + kModality + ": modality " + s.modality + ", not CT; a CT's values alone are HU");
    if (s.dims[2] != 1)
        refuse(where + kFrames + ": holds several frames; export it as one file per slice, or as NIfTI");
    checkDims(s.dims, where);
    if (s.position.empty())
        refuse(where + kPosition + ": is missing, so its place in the patient is unknown");
    if (s.orientation.empty()) refuse(where + kOrientation + ": is missing, so left and right are unknown");
    if (s.pixel_spacing.empty()) refuse(where + kPixelSpacing + ": is missing, so its scale is unknown");
    checkRescale(s.slope.empty() ? 1.0 : parseDecimal(s.slope),
                 s.intercept.empty() ? 0.0 : parseDecimal(s.intercept), where, kSlope, kIntercept);
}

void checkSlices(const std::vector<Slice>& slices) {
    const Slice& first = slices.front();
    for (const Slice& s : slices) {
        checkSlice(s);
        const std::string pair = first.name() + " and " + s.name();
        if (s.dims != first.dims) refuse(pair + ": Rows and Columns (0028,0010): differ within one series");
        if (std::fabs(s.spacing[0] - first.spacing[0]) > 1e-3 ||
            std::fabs(s.spacing[1] - first.spacing[1]) > 1e-3)
            refuse(pair + ": " + kPixelSpacing + ": their pixel spacing differs within one series");
        if (dot(s.row, first.row) < 0.9999 || dot(s.column, first.column) < 0.9999)
            refuse(pair + ": " + kOrientation +
                   ": lie at different angles; put the axial slices alone into a folder");
    }
}

// Refuses several slices at one position: copies, or several phases or reconstructions in one series.
void checkDuplicates(const std::vector<Slice>& slices, const std::vector<double>& gaps) {
    std::size_t duplicates = 0;
    for (const double gap : gaps)
        duplicates += gap < kSamePosition_mm;
    for (std::size_t i = 0; i < gaps.size(); ++i)
        if (gaps[i] < kSamePosition_mm)
            refuse(
                std::string(kPosition) + ": " + slices[i].name() + " and " + slices[i + 1].name() +
                " lie in the same place" +
                (3 * duplicates >= slices.size()
                     ? ", and so do many more: several phases or reconstructions; put one into a folder of "
                       "its own"
                     : "; remove one of them"));
}

// Sorts the slices along their common normal and returns their spacing [mm]. Refuses fewer than three slices,
// a sheared stack, and slices that are missing, duplicated or unevenly spaced. The message names the files
// next to the gap.
double orderSlices(std::vector<Slice>& slices) {
    const V3 normal = cross(slices.front().row, slices.front().column);
    for (Slice& s : slices)
        s.along = dot(s.origin, normal);
    std::sort(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) { return a.along < b.along; });
    if (slices.size() < 3)
        refuse("only " + std::to_string(slices.size()) + (slices.size() == 1 ? " slice" : " slices") +
               "; a volume needs three");
    std::vector<double> gaps;
    for (std::size_t i = 1; i < slices.size(); ++i)
        gaps.push_back(slices[i].along - slices[i - 1].along);
    checkDuplicates(slices, gaps);
    const double median_gap = upperMedian(gaps);
    for (std::size_t i = 0; i < gaps.size(); ++i) {
        const std::string pair = slices[i].name() + " and " + slices[i + 1].name();
        if (gaps[i] > 1.5 * median_gap)
            refuse(std::string(kPosition) + ": slices are missing between " + pair + ": a gap of " +
                   formatNumber(gaps[i]) + " mm where " + formatNumber(median_gap) +
                   " mm is usual; export the whole series");
        if (std::fabs(gaps[i] - median_gap) > 0.1 * median_gap)
            refuse(std::string(kPosition) + ": the slice spacing is uneven: " + formatNumber(gaps[i]) +
                   " mm between " + pair + ", usually " + formatNumber(median_gap) + " mm");
    }
    const Slice &first = slices.front(), &last = slices.back();
    const V3 run{last.origin[0] - first.origin[0], last.origin[1] - first.origin[1],
                 last.origin[2] - first.origin[2]};
    const double rise = dot(run, normal), length = std::sqrt(dot(run, run));
    if (std::sqrt(std::max(0.0, length * length - rise * rise)) > kShear_mm)
        refuse(std::string(kPosition) + ": the slices are sheared by " + formatDegrees(rise / length) +
               " (a tilted gantry); export the series resampled to upright slices");
    return rise / double(slices.size() - 1);
}

}  // namespace

bool isDicom(const fs::path& file) {
    return readFileMeta(file).has_value();
}

RawImage readDicomFolder(const fs::path& folder, const std::string& series) {
    std::vector<Slice> slices = readHeaders(folder);
    selectSeries(slices, series);
    checkSlices(slices);
    const double spacing = orderSlices(slices);
    const Slice& first = slices.front();
    RawImage image;
    image.dims = {first.dims[0], first.dims[1], std::int64_t(slices.size())};
    checkDims(image.dims, "");
    image.spacing = {first.spacing[0], first.spacing[1], spacing};
    image.origin = first.origin;
    image.axes = {first.row, first.column, cross(first.row, first.column)};
    const std::size_t per_slice = std::size_t(image.dims[0] * image.dims[1]);
    image.voxels.resize(per_slice * slices.size());
    for (std::size_t i = 0; i < slices.size(); ++i) {
        const std::string where = slices[i].name() + ": ";
        auto io = itk::GDCMImageIO::New();  // applies slope and intercept
        io->SetFileName(slices[i].file.string());
        try {
            io->ReadImageInformation();
            readVoxels(*io, false, where, image.voxels.data() + i * per_slice, per_slice);
        } catch (const itk::ExceptionObject&) {
            refuseUnreadable(where, slices[i].meta, "its pixels");
        }
    }
    return image;
}

RawImage readDicomFrames(const fs::path& file) {
    auto io = itk::GDCMImageIO::New();
    io->SetFileName(file.string());
    io->SetMaxSizeLoadEntry(4096);
    try {
        io->ReadImageInformation();
        if (io->GetNumberOfDimensions() != 3 || io->GetDimensions(2) < 3)
            refuse("a single slice; a phase is one volume");
        RawImage image = readVolume(*io, false);
        std::string position;
        if (!itk::ExposeMetaData<std::string>(io->GetMetaDataDictionary(), "0020|0032", position)) {
            image.origin = {0.0, 0.0, 0.0};
            image.axes = {V3{1.0, 0.0, 0.0}, V3{0.0, 1.0, 0.0}, V3{0.0, 0.0, -1.0}};
        }
        return image;
    } catch (const itk::ExceptionObject&) {
        refuse("not a readable DICOM volume (damaged or cut short)");
    }
}

}  // namespace stylet::modeller
