// Contact of the probe's face with the skin, line by line. Computed on the host before anything is scanned.
#pragma once

#include <vector>

#include "render/ultrasound/acoustics.h"
#include "render/ultrasound/scan.h"
#include "render/volume/deformed_patient.h"

namespace stylet::render {

struct LineContact {
    double gel_m = 0.0;     // thickness of the gel in front of the skin
    double coupling = 0.0;  // two-way amplitude; 0: air
};

struct Contact {
    std::vector<LineContact> lines;
    double share = 0.0;    // share of the face that touches
    bool in_bone = false;  // the middle of the face lies in bone
};
// The deformed patient with the acoustics of its tissues. `label_rows`: the table's row of each label.
struct AcousticPatient {
    const DeformedPatient& patient;
    const AcousticTable& table;
    const std::array<int, 256>& label_rows;
};
// Fills `contact`. Allocates only if it has fewer lines than the settings.
void findContact(const Transducer&, const UltrasoundSettings&, const Pose& patient_from_probe,
                 const AcousticPatient&, Contact& contact);

}  // namespace stylet::render
