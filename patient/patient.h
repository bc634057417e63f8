// The virtual patient: what it is made of, how it breathes, where a needle may go.
//
// Frames (a transform is named a_from_b and cancels when read aloud):
//   patient    RAS, the CT's own: +x right, +y front, +z head; metres
//   reference  the patient frame with the tissue where the CT saw it (Package::reference_phase)
//   deformed   the patient frame with the tissue where it is at time t
//   stage      OpenXR: +x right, +y up, -z forward, origin on the floor
//   device     the haptic device's base
//   stylus     the device's moving handle
//   needle     tip at the origin, +z along the shaft toward the hub
//   probe      the ultrasound probe: face centre at the origin, +z into the body
//   eye        an OpenXR view: +x right, +y up, -z forward
#pragma once

// In order of use.
// clang-format off
#include "patient/geometry.h"        // points, poses, grids
#include "patient/volume.h"          // voxel volumes
#include "patient/traversal.h"       // voxels along a segment
#include "patient/tissue.h"          // the force table, labels, thresholds
#include "patient/signal.h"          // the breath as a signal, counted in ticks
#include "patient/recording.h"       // a recorded one
#include "patient/motion.h"            // what it moves: two velocity fields and their flows at a point
#include "patient/motion_template.h"   // such fields for a patient of whom there is one CT
#include "patient/motion_interface.h"  // where the two sides slide: made tangential, measured
#include "patient/package.h"         // packages on disk, and the tissue at a point
#include "patient/segmentation.h"    // how much of him is segmented
#include "patient/skin.h"            // the surface as a smooth signed distance
#include "patient/tissue_map.h"    // the tissue of all voxels, for walks along many paths
#include "patient/planning.h"        // reference paths
#include "patient/vessel_flow.h"     // where the blood goes, for Doppler and what it carries
#include "patient/contrast.h"        // contrast medium: what became of every drop
#include "patient/contrast_table.h"  // and the attenuation it adds
#include "patient/hash.h"            // the state hash
#include "patient/spline.h"          // smooth look-up between the nodes of a grid
#include "patient/parallel.h"        // work on several threads, at load
#include "patient/transcendental.h"  // exp, sin and cos with the same bits on every machine
