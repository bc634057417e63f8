// Fixture that skips tests where there is no GPU, and a renderer for these tests.
#pragma once

#include <gtest/gtest.h>

#include <utility>

#include "tests/render/pictures.h"

namespace stylet::test {

// `Base`: testing::Test, or testing::TestWithParam<...>.
template <typename Base = testing::Test>
class GpuFixture : public Base {
  protected:
    void SetUp() override {
        if (const auto why = noGpuReason(); !why.empty()) GTEST_SKIP() << why;
    }
};

// A renderer that shows one patient. At the end it expects that there were no validation messages.
struct PatientRenderer {
    explicit PatientRenderer(patient::Package shown, const render::RenderSettings& settings = {},
                             bool validation = true)
        : package(std::move(shown)),
          gpu({.validation = validation}),
          renderer(gpu, settings, assetsFolder()) {
        renderer.setPatient(patient);
    }
    ~PatientRenderer() { EXPECT_EQ(gpu.validationMessages(), 0u); }

    const patient::Package package;
    const patient::Patient patient{package};
    render::Gpu gpu;
    render::Renderer renderer;
};

}  // namespace stylet::test
