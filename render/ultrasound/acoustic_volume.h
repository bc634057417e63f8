// Acoustic volume of the patient: a tissue per voxel. A voxel that a border crosses also stores the border as
// a plane, so that a look-up of one voxel gives a surface without steps, and its normal. Based on the
// piecewise linear interfaces of volume-of-fluid methods (Youngs 1982), computed from labels.
#pragma once

#include <cstdint>
#include <vector>

#include "render/ultrasound/acoustics.h"
#include "render/volume/workers.h"

namespace stylet::render {

// Packed into 32 bits (scan_shared.h). The tissue is `other` where dot(normal, p) > near; p is in voxels,
// from the voxel's centre.
struct AcousticVoxel {
    int tissue = 0, other = 0;
    bool border = false;
    double near = 0.0;  // 0 to kNearRange
    Vec3 normal{0.0, 0.0, 1.0};
    double variation = 0.0;  // (CT value - hu_centre) / hu_span, -1 to 1
};
std::uint32_t pack(const AcousticVoxel&);
AcousticVoxel unpack(std::uint32_t);

// Row of the table for a voxel.
int acousticAt(const patient::Patient&, const AcousticTable&, const std::array<int, 256>& label_rows,
               const Index3&);

// Encodes planes [z0, z1) of all the patient's voxels: packed, x-fastest.
class AcousticEncoder {
  public:
    AcousticEncoder(const patient::Patient&, const AcousticTable&, Workers&);
    void encode(int z0, int z1, std::uint32_t* out) const;

  private:
    AcousticVoxel voxelAt(const Index3&) const;
    bool isSurroundedBySame(const Index3&) const;
    void findBorder(const Index3&, AcousticVoxel&) const;
    int at(const Index3&) const;

    const patient::Patient* patient_;
    const AcousticTable* table_;
    Workers* workers_;
    std::vector<std::uint8_t> rows_;
};

}  // namespace stylet::render
