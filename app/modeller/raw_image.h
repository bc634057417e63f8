// Internal to `stylet-image-reader`: an image as its file has it, and what every reader of one needs.
#pragma once

#include <itkImageIOBase.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/modeller/image_handover.h"

namespace stylet::modeller {

using V3 = std::array<double, 3>;

// Voxels as stored, in HU, with the frame ITK reports: LPS, millimetres.
struct RawImage {
    std::array<std::int64_t, 3> dims{};
    V3 spacing{}, origin{};
    std::array<V3, 3> axes{};  // unit vectors of i, j, k
    std::vector<std::int16_t> voxels;
};

// Of one series where a folder holds several; of the only one where `series` is empty. What is refused throws
// std::runtime_error: a sentence that names file, field and reason.
RawImage readDicomFolder(const std::filesystem::path&, const std::string& series);
// One phase of a 4D CT as one DICOM file of many frames. Such exports often name neither place nor spacing:
// slices are then taken to be axial, from head to feet, and what ITK supposes (1 mm) holds for the spacing.
RawImage readDicomFrames(const std::filesystem::path&);
bool isDicom(const std::filesystem::path&);

enum class NiftiKind { ct, labels, phase };  // a phase need not say where it lies
RawImage readNifti(const std::filesystem::path&, NiftiKind);

inline constexpr double kUpright = 0.996;  // cosine of 5 degrees

// The caller has named the file or folder; `where` begins a sentence about one of a folder: "slice12.dcm: ".
[[noreturn]] void refuse(const std::string& sentence);
std::string number(double);
std::string degrees(double cosine);
V3 axis(const itk::ImageIOBase&, unsigned i);
void checkDims(const std::array<std::int64_t, 3>& dims, const std::string& where);
// Of stored values into HU: a wrong line makes bone of water.
void checkRescale(double slope, double intercept, const std::string& where, const char* slope_field,
                  const char* intercept_field);
// The pixels of an ImageIO whose information has been read.
void readVoxels(itk::ImageIOBase&, bool labels, const std::string& where, std::int16_t* out,
                std::size_t count);

}  // namespace stylet::modeller
