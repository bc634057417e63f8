// Child process that registers two CT images. FIXED, MOVING and MASK are image files, AFFINE is an affine
// transform and OUT a displacement field (image_handover.h). There are three modes.
//
// 1. Two breathing phases of one patient: stylet-register phases FIXED MOVING MASK OUT FINEST
// Lungs and liver slide along the chest wall, so each side of this sliding interface is registered
// separately. MASK selects one side. The method is ITK's diffeomorphic demons (Vercauteren et al. 2009),
// coarse to fine, with one change: the displacement and update fields are smoothed only within the mask. The
// tissue on the other side of the interface therefore does not drag on the selected side. The caller has set
// all voxels outside the mask to one value, so no demons force acts there, and the motion normal to the
// interface stays zero. FINEST is the smallest shrink factor used (1, 2 or 4).
//
// 2. Two patients: stylet-register affine FIXED MOVING AFFINE SHARE
// The images have different grids and may show different sections of the body. First the size and the shift
// between the sections are found, then AFFINE (mean squares). Voxels of FIXED outside MOVING are compared
// with air. Otherwise a smaller overlap could reduce the difference.
//
// 3. Two patients: stylet-register demons FIXED MOVING AFFINE OUT ITERATIONS
// Goes on from AFFINE with a demons displacement. The demons run ITERATIONS times on the coarsest level and
// half as often on each finer level. No demons force acts where FIXED lies outside MOVING.
#include <itkAffineTransform.h>
#include <itkDiffeomorphicDemonsRegistrationFilter.h>
#include <itkImage.h>
#include <itkImageRegistrationMethodv4.h>
#include <itkLinearInterpolateImageFunction.h>
#include <itkMeanSquaresImageToImageMetricv4.h>
#include <itkMultiThreaderBase.h>
#include <itkRegistrationParameterScalesFromPhysicalShift.h>
#include <itkRegularStepGradientDescentOptimizerv4.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/modeller/image/image_handover.h"
#include "base/memory_linux.h"
#include "base/text.h"

namespace {

using stylet::modeller::AffineHandover;
using stylet::modeller::ImageHandover;
using stylet::modeller::kAffineMagic;
using stylet::modeller::kFieldMagic;
using stylet::modeller::kImageMagic;
using stylet::modeller::kMaxImageVoxels;

using FloatImage = itk::Image<float, 3>;
using Field = itk::Image<itk::Vector<float, 3>, 3>;

// One resolution level of the demons. Each voxel of the level merges shrink^3 voxels of the image.
struct Level {
    int shrink, iterations;
};
constexpr Level kLevels[] = {{4, 80}, {2, 40}, {1, 12}};  // for two phases of one patient
constexpr double kSigmaField = 1.5, kSigmaUpdate = 1.0;   // Gaussian smoothing, in voxels of the level
constexpr double kMaxUpdateStep = 1.5;                    // in voxels per iteration
// Settings for two patients. The affine transform is found on images shrunk by kAffineShrink per axis. When
// the sections are aligned in height, they must overlap by at least kMinOverlap of the shorter section.
// Where the patients' heights differ, a quarter of these iterations is too few.
constexpr int kAffineShrink = 2, kAffineIterations = 400;
constexpr double kMinOverlap = 0.6;
constexpr double kSurround_mm = 120.0;  // thickness of the air around MOVING
// Sizes of MOVING relative to FIXED from which the affine transform starts: large and small adults.
constexpr double kStartSizes[] = {0.8, 0.9, 1.0, 1.12, 1.25};
constexpr unsigned kWorkUnits = 2;  // fixed, because the threads' summation order must be fixed

std::array<int, 3> dimensions(const itk::ImageBase<3>& image) {
    const auto size = image.GetLargestPossibleRegion().GetSize();
    return {int(size[0]), int(size[1]), int(size[2])};
}

// A new image; its voxels are not initialised.
template <typename Image>
typename Image::Pointer makeImage(const FloatImage::RegionType& region,
                                  const FloatImage::SpacingType& spacing,
                                  const FloatImage::PointType& origin) {
    auto image = Image::New();
    image->SetRegions(region);
    image->SetSpacing(spacing);
    image->SetOrigin(origin);
    image->Allocate();
    return image;
}

FloatImage::Pointer read(const std::string& file, ImageHandover& h) {
    std::ifstream in(file, std::ios::binary);
    if (!in.read(reinterpret_cast<char*>(&h), sizeof h) || h.magic != kImageMagic)
        throw std::runtime_error(file + ": not an image");
    FloatImage::RegionType region;
    FloatImage::SpacingType spacing;
    FloatImage::PointType origin;
    std::int64_t count = 1;
    for (unsigned d = 0; d < 3; ++d) {
        region.SetSize(d, itk::SizeValueType(h.dims[d]));
        spacing[d] = h.spacing_mm[d];
        origin[d] = h.origin_mm[d];
        count *= h.dims[d];
    }
    if (count < 1 || count > kMaxImageVoxels) throw std::runtime_error(file + ": too large");
    std::vector<std::int16_t> voxels(std::size_t(count), 0);
    if (!in.read(reinterpret_cast<char*>(voxels.data()), count * 2))
        throw std::runtime_error(file + ": cut short");
    auto picture = makeImage<FloatImage>(region, spacing, origin);
    std::copy(voxels.begin(), voxels.end(), picture->GetBufferPointer());
    return picture;
}

// Downsamples the image: each output voxel is the mean of a cube of shrink^3 input voxels. The origin of the
// output is shifted so that each output voxel lies at the centre of its cube.
FloatImage::Pointer downsampled(const FloatImage& in, int shrink) {
    const auto dims = dimensions(in);
    FloatImage::RegionType region;
    FloatImage::SpacingType spacing = in.GetSpacing();
    FloatImage::PointType origin = in.GetOrigin();
    std::array<int, 3> out_dims{};
    for (unsigned d = 0; d < 3; ++d) {
        out_dims[d] = std::max(1, dims[d] / shrink);
        region.SetSize(d, itk::SizeValueType(out_dims[d]));
        origin[d] += 0.5 * (shrink - 1) * spacing[d];
        spacing[d] *= shrink;
    }
    auto out = makeImage<FloatImage>(region, spacing, origin);
    const float* from = in.GetBufferPointer();
    float* to = out->GetBufferPointer();
    for (int z = 0; z < out_dims[2]; ++z)
        for (int y = 0; y < out_dims[1]; ++y)
            for (int x = 0; x < out_dims[0]; ++x) {
                double sum = 0.0;
                for (int k = 0; k < shrink; ++k)
                    for (int j = 0; j < shrink; ++j)
                        for (int i = 0; i < shrink; ++i) {
                            const int ix = std::min(dims[0] - 1, x * shrink + i),
                                      iy = std::min(dims[1] - 1, y * shrink + j),
                                      iz = std::min(dims[2] - 1, z * shrink + k);
                            sum += double(from[(std::ptrdiff_t(iz) * dims[1] + iy) * dims[0] + ix]);
                        }
                *to++ = float(sum / (shrink * shrink * shrink));
            }
    return out;
}

// Gaussian blur along one axis, with `n` interleaved floats per voxel. Each task blurs a line along x, a
// slice along y, or the rows with the same y along z. The innermost loop runs over floats that follow each
// other in memory.
void blurAxis(std::vector<float>& values, std::size_t n, const std::array<int, 3>& dims, unsigned axis,
              double sigma) {
    const int reach = int(std::ceil(3.0 * sigma)), length = dims[axis];
    std::vector<float> kernel(std::size_t(2 * reach + 1));
    for (int i = -reach; i <= reach; ++i)
        kernel[std::size_t(i + reach)] = float(std::exp(-0.5 * i * i / (sigma * sigma)));
    const std::size_t row = n * std::size_t(dims[0]), slice = row * std::size_t(dims[1]);
    const std::size_t width = axis == 0 ? n : row;  // floats at the same place along the axis, in one task
    const std::size_t stride = axis == 2 ? slice : width;
    const std::size_t between_tasks = axis == 1 ? slice : row;
    const int tasks = axis == 0 ? dims[1] * dims[2] : axis == 1 ? dims[2] : dims[1];
    auto threads = itk::MultiThreaderBase::New();
    threads->ParallelizeArray(
        0, itk::SizeValueType(tasks),
        [&](itk::SizeValueType task) {
            float* const from = values.data() + task * between_tasks;
            std::vector<float> out(std::size_t(length) * width, 0.0f);
            for (int k = -reach; k <= reach; ++k) {
                const float weight = kernel[std::size_t(k + reach)];
                const auto add = [&](int at, std::size_t floats) {
                    float* const to = out.data() + std::size_t(at) * width;
                    const float* const shifted = from + std::size_t(at + k) * stride;
                    for (std::size_t i = 0; i < floats; ++i)
                        to[i] += weight * shifted[i];
                };
                const int first = std::max(0, -k), end = std::min(length, length - k);
                if (first >= end) continue;
                if (stride == width)  // the places follow each other in memory
                    add(first, std::size_t(end - first) * width);
                else
                    for (int at = first; at < end; ++at)
                        add(at, width);
            }
            for (int at = 0; at < length; ++at)
                std::copy_n(out.data() + std::size_t(at) * width, width, from + std::size_t(at) * stride);
        },
        nullptr);
}

// Smooths the field by a Gaussian weighted with the mask, so that values outside the mask have almost no
// influence within it. Just outside the mask, the result continues the values at the mask's border. Samples
// taken there during warping therefore move with the tissue.
void smoothWithin(Field& field, const FloatImage& mask, double sigma) {
    const auto dims = dimensions(field);
    const std::size_t count = field.GetLargestPossibleRegion().GetNumberOfPixels();
    std::vector<float> sum(4 * count);
    auto* vectors = field.GetBufferPointer();
    const float* weights = mask.GetBufferPointer();
    for (std::size_t i = 0; i < count; ++i) {
        const float w = std::max(weights[i], 1e-4f);
        for (unsigned c = 0; c < 3; ++c)
            sum[4 * i + c] = w * vectors[i][c];
        sum[4 * i + 3] = w;
    }
    for (unsigned axis = 0; axis < 3; ++axis)
        blurAxis(sum, 4, dims, axis, sigma);
    for (std::size_t i = 0; i < count; ++i)
        for (unsigned c = 0; c < 3; ++c)
            vectors[i][c] = sum[4 * i + c] / sum[4 * i + 3];
}

class MaskedDemons : public itk::DiffeomorphicDemonsRegistrationFilter<FloatImage, FloatImage, Field> {
  public:
    using Self = MaskedDemons;
    using Superclass = itk::DiffeomorphicDemonsRegistrationFilter<FloatImage, FloatImage, Field>;
    using Pointer = itk::SmartPointer<Self>;
    FloatImage::Pointer mask;
  itkNewMacro(Self)

      protected : void SmoothDisplacementField() override {
        smoothWithin(*this->GetDisplacementField(), *mask, kSigmaField);
    }
    void SmoothUpdateField() override { smoothWithin(*this->GetUpdateBuffer(), *mask, kSigmaUpdate); }
};

// Resamples the coarse field on the grid of `reference`, linearly between voxels.
Field::Pointer upsampledField(const Field& coarse, const FloatImage& reference) {
    auto fine =
        makeImage<Field>(reference.GetLargestPossibleRegion(), reference.GetSpacing(), reference.GetOrigin());
    const auto from = dimensions(coarse), to = dimensions(reference);
    const auto* in = coarse.GetBufferPointer();
    auto* out = fine->GetBufferPointer();
    const auto at = [&](int x, int y, int z) { return in[(std::ptrdiff_t(z) * from[1] + y) * from[0] + x]; };
    for (int z = 0; z < to[2]; ++z)
        for (int y = 0; y < to[1]; ++y)
            for (int x = 0; x < to[0]; ++x) {
                const std::array<int, 3> i{x, y, z};
                std::array<int, 3> low{}, high{};
                std::array<float, 3> f{};
                for (unsigned d = 0; d < 3; ++d) {
                    const double p = (reference.GetOrigin()[d] + i[d] * reference.GetSpacing()[d] -
                                      coarse.GetOrigin()[d]) /
                                     coarse.GetSpacing()[d];
                    low[d] = std::clamp(int(std::floor(p)), 0, from[d] - 1);
                    high[d] = std::min(low[d] + 1, from[d] - 1);
                    f[d] = float(std::clamp(p - low[d], 0.0, 1.0));
                }
                itk::Vector<float, 3> sum(0.0f);
                for (int corner = 0; corner < 8; ++corner) {
                    const bool ux = (corner & 1) != 0, uy = (corner & 2) != 0, uz = (corner & 4) != 0;
                    const float weight =
                        (ux ? f[0] : 1.0f - f[0]) * (uy ? f[1] : 1.0f - f[1]) * (uz ? f[2] : 1.0f - f[2]);
                    sum += at(ux ? high[0] : low[0], uy ? high[1] : low[1], uz ? high[2] : low[2]) * weight;
                }
                *out++ = sum;
            }
    return fine;
}

Field::Pointer runDemons(const FloatImage& fixed, const FloatImage& moving, const FloatImage& mask,
                         const std::vector<Level>& levels) {
    Field::Pointer field;
    for (const Level& level : levels) {
        const auto level_fixed = downsampled(fixed, level.shrink);
        auto demons = MaskedDemons::New();
        demons->mask = downsampled(mask, level.shrink);
        demons->SetFixedImage(level_fixed);
        demons->SetMovingImage(downsampled(moving, level.shrink));
        if (field) demons->SetInitialDisplacementField(upsampledField(*field, *level_fixed));
        demons->SetNumberOfIterations(itk::IdentifierType(level.iterations));
        demons->SetMaximumUpdateStepLength(kMaxUpdateStep);
        demons->SmoothUpdateFieldOn();
        demons->SmoothDisplacementFieldOn();
        demons->Update();
        field = demons->GetOutput();
        field->DisconnectPipeline();
    }
    return field;
}

Field::Pointer registerPhasePair(const FloatImage& fixed, const FloatImage& moving, const FloatImage& mask,
                                 int finest) {
    std::vector<Level> levels;
    for (const Level& level : kLevels)
        if (level.shrink >= finest) levels.push_back(level);
    return runDemons(fixed, moving, mask, levels);
}

using Affine = itk::AffineTransform<double, 3>;
using Interpolator = itk::LinearInterpolateImageFunction<FloatImage, double>;

template <typename Visit>
void forEachVoxel(const FloatImage& image, const Visit& visit) {
    const auto dims = dimensions(image);
    std::ptrdiff_t i = 0;
    for (int z = 0; z < dims[2]; ++z)
        for (int y = 0; y < dims[1]; ++y)
            for (int x = 0; x < dims[0]; ++x, ++i) {
                FloatImage::PointType p;
                p[0] = image.GetOrigin()[0] + x * image.GetSpacing()[0];
                p[1] = image.GetOrigin()[1] + y * image.GetSpacing()[1];
                p[2] = image.GetOrigin()[2] + z * image.GetSpacing()[2];
                visit(i, p);
            }
}

// The value of voxels outside the body: the image's lowest.
float airValue(const FloatImage& image) {
    const float* v = image.GetBufferPointer();
    return *std::min_element(v, v + image.GetLargestPossibleRegion().GetNumberOfPixels());
}

// The centre of the body.
FloatImage::PointType foregroundCentroid(const FloatImage& image) {
    const float* v = image.GetBufferPointer();
    const float outside = airValue(image);
    itk::Vector<double, 3> sum(0.0);
    double count = 0.0;
    forEachVoxel(image, [&](std::ptrdiff_t i, const FloatImage::PointType& p) {
        if (v[i] > outside) sum += p.GetVectorFromOrigin(), count += 1.0;
    });
    FloatImage::PointType middle;
    for (unsigned d = 0; d < 3; ++d)
        middle[d] = count > 0.0 ? sum[d] / count : 0.0;
    return middle;
}

// Returns the transform that scales FIXED about the centre of its body and then shifts it.
Affine::Pointer makeStart(const FloatImage::PointType& centre, double size,
                          const itk::Vector<double, 3>& shift) {
    auto affine = Affine::New();
    affine->SetCenter(centre);
    affine->Scale(size);
    affine->SetTranslation(shift);
    return affine;
}

// Tries sizes of the patient and shifts in height, and returns the transform with the smallest mean squared
// difference between the images. In x and y it aligns the centres of the two bodies.
Affine::Pointer estimateStart(const FloatImage& fixed, const FloatImage& moving) {
    const int nf = dimensions(fixed)[2], nm = dimensions(moving)[2];
    const double dz = fixed.GetSpacing()[2], fixed_low = fixed.GetOrigin()[2],
                 moving_low = moving.GetOrigin()[2];
    const auto centre = foregroundCentroid(fixed);
    const auto centre_shift = foregroundCentroid(moving) - centre;
    auto interpolator = Interpolator::New();
    interpolator->SetInputImage(&moving);
    const float air = airValue(moving);
    auto best = makeStart(centre, 1.0, centre_shift);
    double lowest = std::numeric_limits<double>::infinity();
    for (const double size : kStartSizes) {
        const double slices = size * nf;  // height of FIXED in slices of MOVING
        const double min_overlap = kMinOverlap * std::min(slices, double(nm));
        // Shift k places the lower end of FIXED on slice k of MOVING.
        for (int k = int(std::ceil(min_overlap - slices)); k <= int(nm - min_overlap); ++k) {
            auto shift = centre_shift;
            shift[2] = moving_low + k * dz - (centre[2] + size * (fixed_low - centre[2]));
            const auto transform = makeStart(centre, size, shift);
            double sum = 0.0;
            forEachVoxel(fixed, [&](std::ptrdiff_t i, const FloatImage::PointType& p) {
                const auto q = transform->TransformPoint(p);
                const double there =
                    interpolator->IsInsideBuffer(q) ? interpolator->Evaluate(q) : double(air);
                const double d = there - double(fixed.GetBufferPointer()[i]);
                sum += d * d;
            });
            if (sum >= lowest) continue;
            lowest = sum;
            best = transform;
        }
    }
    return best;
}

// The image with air around it.
FloatImage::Pointer surrounded(const FloatImage& in) {
    const auto dims = dimensions(in);
    FloatImage::RegionType region;
    FloatImage::PointType origin = in.GetOrigin();
    std::array<int, 3> margin{};
    for (unsigned d = 0; d < 3; ++d) {
        margin[d] = int(std::ceil(kSurround_mm / in.GetSpacing()[d]));
        region.SetSize(d, itk::SizeValueType(dims[d] + 2 * margin[d]));
        origin[d] -= margin[d] * in.GetSpacing()[d];
    }
    auto out = makeImage<FloatImage>(region, in.GetSpacing(), origin);
    out->FillBuffer(airValue(in));
    const auto to = dimensions(*out);
    const float* line = in.GetBufferPointer();
    for (int z = 0; z < dims[2]; ++z)
        for (int y = 0; y < dims[1]; ++y, line += dims[0])
            std::copy(line, line + dims[0],
                      out->GetBufferPointer() +
                          ((std::ptrdiff_t(z) + margin[2]) * to[1] + y + margin[1]) * to[0] + margin[0]);
    return out;
}

// Compares `share` times as many random points as `fixed`, shrunken, has voxels. 0 < share <= 1.
Affine::Pointer estimateAffine(const FloatImage& fixed, const FloatImage& moving, double share) {
    using Method = itk::ImageRegistrationMethodv4<FloatImage, FloatImage, Affine>;
    const auto f = downsampled(fixed, kAffineShrink), m = surrounded(*downsampled(moving, kAffineShrink));
    const auto affine =
        estimateStart(*downsampled(fixed, 2 * kAffineShrink), *downsampled(moving, 2 * kAffineShrink));
    auto metric = itk::MeanSquaresImageToImageMetricv4<FloatImage, FloatImage>::New();
    metric->SetMaximumNumberOfWorkUnits(kWorkUnits);
    auto scales = itk::RegistrationParameterScalesFromPhysicalShift<
        itk::MeanSquaresImageToImageMetricv4<FloatImage, FloatImage>>::New();
    scales->SetMetric(metric);
    auto optimizer = itk::RegularStepGradientDescentOptimizerv4<double>::New();
    optimizer->SetScalesEstimator(scales);
    optimizer->SetDoEstimateLearningRateOnce(true);
    optimizer->SetMinimumStepLength(0.01);
    optimizer->SetNumberOfIterations(kAffineIterations);
    optimizer->SetNumberOfWorkUnits(kWorkUnits);
    auto method = Method::New();
    method->SetFixedImage(f);
    method->SetMovingImage(m);
    method->SetMetric(metric);
    method->SetOptimizer(optimizer);
    method->SetInitialTransform(affine);
    method->InPlaceOn();
    method->SetNumberOfLevels(1);
    itk::Array<itk::SizeValueType> shrink(1);
    shrink.Fill(1);
    method->SetShrinkFactorsPerLevel(shrink);
    itk::Array<double> sigmas(1);
    sigmas.Fill(0.0);
    method->SetSmoothingSigmasPerLevel(sigmas);
    method->SetMetricSamplingStrategy(Method::MetricSamplingStrategyEnum::RANDOM);
    method->SetMetricSamplingPercentage(share);
    method->MetricSamplingReinitializeSeed(1);  // the result must be the same in every run
    method->Update();
    return affine;
}

// MOVING resampled on the grid of FIXED. Where MOVING has no data, FIXED is copied.
FloatImage::Pointer resampled(const FloatImage& fixed, const FloatImage& moving, const Affine& affine) {
    auto out = downsampled(fixed, 1);
    auto interpolator = Interpolator::New();
    interpolator->SetInputImage(&moving);
    float* v = out->GetBufferPointer();
    forEachVoxel(*out, [&](std::ptrdiff_t i, const FloatImage::PointType& p) {
        const auto q = affine.TransformPoint(p);
        if (interpolator->IsInsideBuffer(q)) v[i] = float(interpolator->Evaluate(q));
    });
    return out;
}

void writeAffine(const Affine& affine, const std::string& file) {
    AffineHandover h;
    for (unsigned row = 0; row < 3; ++row) {
        for (unsigned column = 0; column < 3; ++column)
            h.matrix[row][column] = affine.GetMatrix()(row, column);
        h.centre_mm[row] = affine.GetCenter()[row];
        h.shift_mm[row] = affine.GetTranslation()[row];
    }
    std::ofstream out(file, std::ios::binary);
    if (!out.write(reinterpret_cast<const char*>(&h), sizeof h).flush())
        throw std::runtime_error(
            "the transform cannot be written to the temporary folder; free some disk space");
}

Affine::Pointer readAffine(const std::string& file) {
    AffineHandover h;
    std::ifstream in(file, std::ios::binary);
    if (!in.read(reinterpret_cast<char*>(&h), sizeof h) || h.magic != kAffineMagic)
        throw std::runtime_error(file + ": no transform");
    Affine::MatrixType matrix;
    Affine::InputPointType centre;
    Affine::OutputVectorType shift;
    for (unsigned row = 0; row < 3; ++row) {
        for (unsigned column = 0; column < 3; ++column)
            matrix(row, column) = h.matrix[row][column];
        centre[row] = h.centre_mm[row];
        shift[row] = h.shift_mm[row];
    }
    auto affine = Affine::New();
    affine->SetCenter(centre);
    affine->SetMatrix(matrix);
    affine->SetTranslation(shift);
    return affine;
}

Field::Pointer registerPatients(const FloatImage& fixed, const FloatImage& moving, const Affine& affine,
                                int iterations) {
    const auto everywhere = downsampled(fixed, 1);
    everywhere->FillBuffer(1.0f);
    std::vector<Level> levels;
    for (int shrink = 4; shrink >= 1; shrink /= 2, iterations /= 2)
        levels.push_back({shrink, iterations});
    const auto field = runDemons(fixed, *resampled(fixed, moving, affine), *everywhere, levels);
    // The demons displacement u maps a point p of FIXED to p + u in the resampled image. Apply the affine
    // transform to p + u, so that the field maps p directly to MOVING.
    auto* u = field->GetBufferPointer();
    forEachVoxel(fixed, [&](std::ptrdiff_t i, const FloatImage::PointType& p) {
        const auto q = affine.TransformPoint(p + itk::Vector<double, 3>(u[i]));
        for (unsigned d = 0; d < 3; ++d)
            u[i][d] = float(q[d] - p[d]);
    });
    return field;
}

void write(const Field& field, const std::string& file) {
    ImageHandover h;
    h.magic = kFieldMagic;
    for (unsigned d = 0; d < 3; ++d) {
        h.dims[d] = dimensions(field)[d];
        h.spacing_mm[d] = field.GetSpacing()[d];
        h.origin_mm[d] = field.GetOrigin()[d];
    }
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(&h), sizeof h);
    out.write(reinterpret_cast<const char*>(field.GetBufferPointer()),
              std::streamsize(field.GetLargestPossibleRegion().GetNumberOfPixels() * 3 * sizeof(float)));
    if (!out.flush())
        throw std::runtime_error("the field cannot be written to the temporary folder; free some disk space");
}

}  // namespace

int main(int argc, char** argv) {
    const std::string mode = argc > 1 ? argv[1] : "";
    const bool phases = mode == "phases" && argc == 7, affine = mode == "affine" && argc == 6,
               demons = mode == "demons" && argc == 7;
    if (!phases && !affine && !demons) {
        std::puts(
            "usage: stylet-register phases FIXED MOVING MASK OUT FINEST | affine FIXED MOVING AFFINE SHARE | "
            "demons FIXED MOVING AFFINE OUT ITERATIONS");
        return 2;
    }
    stylet::keepFreedMemory();
    try {
        itk::Object::GlobalWarningDisplayOff();
        ImageHandover grid, other;
        const FloatImage::Pointer fixed = read(argv[2], grid), moving = read(argv[3], other);
        if (affine) {
            const auto share = stylet::parseNumber<double>(argv[5]);
            if (!share) throw std::runtime_error("SHARE is not a number");
            writeAffine(*estimateAffine(*fixed, *moving, *share), argv[4]);
            return 0;
        }
        if (demons) {
            write(*registerPatients(*fixed, *moving, *readAffine(argv[4]), std::stoi(argv[6])), argv[5]);
            return 0;
        }
        if (grid.dims != other.dims) throw std::runtime_error("the images differ in size");
        const FloatImage::Pointer mask = read(argv[4], other);
        if (grid.dims != other.dims) throw std::runtime_error("the mask differs in size");
        write(*registerPhasePair(*fixed, *moving, *mask, std::stoi(argv[6])), argv[5]);
        return 0;
    } catch (const itk::ExceptionObject& e) {
        std::puts(e.GetDescription());
    } catch (const std::exception& e) {
        std::puts(e.what());
    }
    return 1;
}
