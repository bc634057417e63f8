// Internal to `stylet-image-reader`: an image as stored in its file, and helpers shared by all readers.
#pragma once

#include <itkImageIOBase.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/modeller/image/image_handover.h"

namespace stylet::modeller {

using V3 = std::array<double, 3>;

// Voxels in HU with the frame that ITK reports: LPS, millimetres.
struct RawImage {
    std::array<std::int64_t, 3> dims{};
    V3 spacing{}, origin{};
    std::array<V3, 3> axes{};  // unit vectors of i, j, k
    std::vector<std::int16_t> voxels;
};

// Reads the series with this UID; if `series` is empty, the folder must contain only one. Errors throw
// std::runtime_error: a sentence that names file, field and reason.
RawImage readDicomFolder(const std::filesystem::path&, const std::string& series);
// Reads one phase of a 4D CT from one multi-frame DICOM file. Such exports often lack position and spacing.
// Then the slices are assumed to be axial from head to feet, and ITK's default spacing (1 mm) is used.
RawImage readDicomFrames(const std::filesystem::path&);
bool isDicom(const std::filesystem::path&);

// Expected content of a NIfTI file. A `phase` is one breathing phase of a 4D CT. Its header may lack the
// orientation and position, which are required for the other two.
enum class NiftiKind { ct, labels, phase };
RawImage readNifti(const std::filesystem::path&, NiftiKind);

inline constexpr double kMinUprightCosine = 0.996;  // cosine of 5 degrees

// The functions below report errors by throwing std::runtime_error. The parent process adds the name of the
// file or folder to the message. `where` is a prefix of the message that names one file within a folder, for
// example "slice12.dcm: ". For a single file it is empty.
[[noreturn]] void refuse(const std::string& sentence);
std::string formatNumber(double);
std::string formatDegrees(double cosine);
V3 readAxis(const itk::ImageIOBase&, unsigned i);
void checkDims(const std::array<std::int64_t, 3>& dims, const std::string& where);
// Checks the linear conversion HU = slope * stored value + intercept. Wrong coefficients could turn water
// into bone.
void checkRescale(double slope, double intercept, const std::string& where, const char* slope_field,
                  const char* intercept_field);
// Reads a 3D volume. The image information must have been read before.
RawImage readVolume(itk::ImageIOBase&, bool labels);
// Reads the pixels of an ImageIO. Its image information must have been read before.
void readVoxels(itk::ImageIOBase&, bool labels, const std::string& where, std::int16_t* out,
                std::size_t count);

}  // namespace stylet::modeller
