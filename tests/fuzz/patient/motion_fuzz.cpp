#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "patient/package/motion_io.h"
#include "patient/patient.h"

// The result is a motion or a DataError. An accepted motion moves every point by a finite, bounded distance
// and does not move points far outside its grid.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::patient;
    MotionModel m;
    m.grid.spacing_m = stylet::Vec3(0.008);
    m.grid.origin_m = stylet::Vec3(-0.016);
    try {
        parseMotion("fuzz.nii", std::as_bytes(std::span(data, size)), m);
    } catch (const stylet::DataError&) {
        return 0;
    }
    const stylet::Vec3 far(20.0);
    for (const Surrogate now : {Surrogate{1.0, 0.5}, Surrogate{1e9, -1e9}, Surrogate{-0.2, 0.0, -0.4}}) {
        for (double x = -0.014; x <= 0.014; x += 0.007)
            for (double z = -0.014; z <= 0.014; z += 0.007) {
                const stylet::Vec3 p(x, 0.3 * x, z);
                for (const stylet::Vec3& q :
                     {deformedFromReference(m, now, p), referenceFromDeformed(m, now, p),
                      motionVelocity_m_s(m, now, 1.0, p), motionJacobian(m, now, p) * p})
                    if (!(glm::dot(q, q) < 100.0)) std::abort();
            }
        if (deformedFromReference(m, now, far) != far) std::abort();
    }
    return 0;
}
