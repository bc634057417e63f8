// Comparison with VTK. Its two volume mappers draw the same picture. Both shade with gradients and a light
// at the eye.
#include <vtkCamera.h>
#include <vtkColorTransferFunction.h>
#include <vtkFixedPointVolumeRayCastMapper.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkOpenGLGPUVolumeRayCastMapper.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPointData.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkShortArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tests/bench/picture_case.h"

namespace stylet::bench {
namespace {

constexpr double kMm = 1000.0;  // millimetres per metre; VTK's scene is in millimetres
constexpr double kReference_voxels = 0.1;

vtkNew<vtkImageData> toVtkImage(const CtVolume& ct) {
    vtkNew<vtkImageData> image;
    image->SetDimensions(ct.grid.dims.x, ct.grid.dims.y, ct.grid.dims.z);
    image->SetSpacing(ct.grid.spacing_m.x * kMm, ct.grid.spacing_m.y * kMm, ct.grid.spacing_m.z * kMm);
    image->SetOrigin(ct.grid.origin_m.x * kMm, ct.grid.origin_m.y * kMm, ct.grid.origin_m.z * kMm);
    image->AllocateScalars(VTK_SHORT, 1);
    std::memcpy(image->GetScalarPointer(), ct.voxels.data(), ct.voxels.size() * sizeof(std::int16_t));
    return image;
}

vtkNew<vtkVolumeProperty> makeVolumeProperty(const render::LookStyle& look, const patient::Patient& patient) {
    const HuTable table = huTable(look, patient);
    vtkNew<vtkPiecewiseFunction> opacity;
    vtkNew<vtkColorTransferFunction> colour;
    constexpr int kEach_hu = 4;
    for (std::size_t i = 0; i < table.extinction_per_m.size(); i += kEach_hu) {
        const double hu = render::Palette::kHuBegin + double(i);
        opacity->AddPoint(hu, 1.0 - std::exp(-table.extinction_per_m[i] / kMm));
        const glm::vec3 c = table.colour_linear[i];
        colour->AddRGBPoint(hu, double(c.r), double(c.g), double(c.b));
    }
    vtkNew<vtkVolumeProperty> property;
    property->SetScalarOpacity(opacity);
    property->SetColor(colour);
    property->SetScalarOpacityUnitDistance(1.0);
    property->SetInterpolationTypeToLinear();
    property->ShadeOn();
    property->SetAmbient(0.2);
    property->SetDiffuse(0.8);
    property->SetSpecular(double(look.specular));
    property->SetSpecularPower(double(look.specular_power));
    return property;
}

struct Window {
    vtkNew<vtkRenderWindow> window;
    vtkNew<vtkRenderer> renderer;
    vtkNew<vtkVolume> volume;

    explicit Window(const PictureCase& c) {
        window->SetOffScreenRendering(1);
        window->SetMultiSamples(0);
        window->AddRenderer(renderer);
        renderer->SetBackground(0.05, 0.05, 0.05);
        renderer->AddVolume(volume);
        vtkCamera* camera = renderer->GetActiveCamera();
        camera->SetPosition(c.eye_m.x * kMm, c.eye_m.y * kMm, c.eye_m.z * kMm);
        camera->SetFocalPoint(c.at_m.x * kMm, c.at_m.y * kMm, c.at_m.z * kMm);
        camera->SetViewUp(0.0, 1.0, 0.0);
        camera->SetViewAngle(2.0 * c.half_angle * 180.0 / M_PI);
        renderer->ResetCameraClippingRange();
    }

    Pixels draw(int extent) {
        window->SetSize(extent, extent);
        window->Render();
        vtkNew<vtkUnsignedCharArray> bytes;
        const int* size = window->GetSize();
        window->GetRGBACharPixelData(0, 0, size[0] - 1, size[1] - 1, 0, bytes);
        Pixels p{size[0], size[1], std::vector<std::uint8_t>(std::size_t(bytes->GetNumberOfValues()))};
        const std::size_t row = std::size_t(4) * std::size_t(p.width);
        for (std::size_t y = 0; y < std::size_t(p.height); ++y)  // VTK's first row is at the bottom
            std::memcpy(p.rgba.data() + (std::size_t(p.height) - 1 - y) * row, bytes->GetPointer(0) + y * row,
                        row);
        return p;
    }
};

std::string vtkVersionText(vtkRenderWindow& window) {
    const std::string all = window.ReportCapabilities(), key = "OpenGL version string:";
    const std::size_t at = all.find(key);
    if (at == std::string::npos) return "";
    return "," + all.substr(at + key.size(), all.find('\n', at) - at - key.size());
}

template <typename Mapper, typename SetStep>
void addRows(const std::string& name, const SetStep& setStep, std::vector<Row>& rows) {
    const PictureCase c;
    const patient::Patient patient(c.package);
    const vtkNew<vtkImageData> image = toVtkImage(c.package.ct);
    const double voxel_mm = c.package.ct.grid.spacing_m.x * kMm;
    for (const char* look : kPictureLooks) {
        const vtkNew<vtkVolumeProperty> property = makeVolumeProperty(pictureLook(look), patient);
        Window window(c);
        const vtkNew<Mapper> mapper;
        mapper->SetInputData(image);
        window.volume->SetMapper(mapper);
        window.volume->SetProperty(property);
        window.draw(64);
        const auto draw = [&](int size, double step) {
            setStep(*mapper, float((step > 0.0 ? step : kReference_voxels) * voxel_mm));
            return window.draw(size);
        };
        matchedRows(name + "." + look, vtkVersionText(*window.window), {2.0, 1.5, 1.0, 0.75, 0.5, 0.35, 0.25},
                    draw, rows);
    }
}

void onGpu(std::vector<Row>& rows) {
    using Mapper = vtkOpenGLGPUVolumeRayCastMapper;
    const auto setStep = [](Mapper& mapper, float step_mm) {
        mapper.SetAutoAdjustSampleDistances(0);
        mapper.SetUseJittering(0);
        mapper.SetSampleDistance(step_mm);
    };
    addRows<Mapper>("render.vtk_gpu", setStep, rows);
}

void onProcessor(std::vector<Row>& rows) {
    using Mapper = vtkFixedPointVolumeRayCastMapper;
    const auto setStep = [](Mapper& mapper, float step_mm) {
        mapper.SetAutoAdjustSampleDistances(0);
        mapper.SetImageSampleDistance(1.0f);
        mapper.SetSampleDistance(step_mm);
    };
    addRows<Mapper>("render.vtk_cpu", setStep, rows);
}

const Registration gpu("render.vtk_gpu", onGpu), processor("render.vtk_cpu", onProcessor);

}  // namespace
}  // namespace stylet::bench
