// Reference position of a sample's tissue. Include after bindings.glsl.
#include "render/volume/deform.glsl"

vec3 referencePosition(vec3 p) {
    if (kPressed) p -= toolMoved(p);
    return kBreathes ? referenceFromDeformed(p) : p;
}

// Position of sample `i` of a line in plane `plane`: patient frame, deformed patient.
vec3 sampleAt(int line, float i, int plane) {
    const int row = clamp(int(i), 0, kSamples - 1);
    return lines[line].origin.xyz + lines[line].direction.xyz * (i * frame.march.x) +
           frame.across.xyz * (depths[row].row.x * frame.planes[plane].x);
}

const int kCoarseLines = kCoarse > 1 ? kCoarse / 2 : 1;  // samples are closer to each other than lines
const int kPlaceColumns = (kSamples + kCoarse - 1) / kCoarse + 1;
const int kPlaceRows = (kLines + kCoarseLines - 1) / kCoarseLines + 1;

// Reference minus deformed position on the coarse grid, interpolated between its rows.
vec3 shiftOnGrid(int line, int column, int plane) {
    // The last row is the last line, so it may be closer than kCoarseLines lines to the row before.
    const int row = line / kCoarseLines, reach = min(kCoarseLines, max(kLines - 1 - row * kCoarseLines, 1));
    const int at = (plane * kPlaceRows + row) * kPlaceColumns + column;
    return mix(places[at].xyz, places[at + kPlaceColumns].xyz, float(line - row * kCoarseLines) / float(reach));
}
