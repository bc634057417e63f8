// A bounded reader and writer of single-file NIfTI-1 volumes (.nii, .nii.gz), by hand on purpose: the C
// library at hand is not hardened against hostile headers. Format: nifti1.h, Cox et al. 2004,
// nifti.nimh.nih.gov.
#pragma once

#include <filesystem>
#include <span>

#include "patient/volume.h"

namespace stylet::patient {

// T is std::int16_t (values rounded, range checked) or std::uint8_t (values must be whole). Reads uint8,
// int16, uint16, int32, float32 and float64 of either byte order, with scl_slope and scl_inter. Axes must be
// those of the patient: flips are undone, oblique or permuted volumes refused. Nothing is allocated before
// its size is known to be sound. Throws DataError.
template <typename T>
Volume<T> readNifti(const std::filesystem::path& file);
// The same from memory, gzip or not; `file` is only named in refusals.
template <typename T>
Volume<T> parseNifti(const std::filesystem::path& file, std::span<const std::byte> bytes);

// Vectors: `components` numbers a voxel, NIfTI's fifth dimension; `voxels` holds all voxels of the first
// component, then all of the second. Every number is finite. Flips are refused: they would turn the vectors.
Volume<float> readNiftiVectors(const std::filesystem::path& file, int components);
Volume<float> parseNiftiVectors(const std::filesystem::path& file, std::span<const std::byte> bytes,
                                int components);
void writeNiftiVectors(const std::filesystem::path& file, const Volume<float>&, int components);

// Compressed when the name ends in .gz. Same volume, same bytes. sform and qform are set, units are mm.
template <typename T>
void writeNifti(const std::filesystem::path& file, const Volume<T>& volume);

}  // namespace stylet::patient
