// The virtual patient: anatomy, breathing motion, planned needle paths.
//
// Frames. A transform is named a_from_b; in a product, equal names meet: a_from_c = a_from_b * b_from_c.
//   patient    RAS, the CT's own: +x right, +y front, +z head; metres
//   reference  the patient frame with the tissue where the CT shows it (Package::reference_phase)
//   deformed   the patient frame with the tissue where it is at time t
//   stage      OpenXR: +x right, +y up, -z forward, origin on the floor
//   device     the haptic device's base
//   stylus     the device's moving handle
//   needle     tip at the origin, +z along the shaft toward the hub
//   probe      the ultrasound probe: face centre at the origin, +z into the body
//   eye        an OpenXR view: +x right, +y up, -z forward
#pragma once

// In order of use. Points, poses, grids and volumes are in base/.
// clang-format off
#include "patient/tissue/tissue.h"               // the force table, labels, thresholds
#include "patient/motion/signal.h"               // the breathing signal, counted in ticks
#include "patient/motion/interruption.h"         // coughs and sighs, added to the breathing signal
#include "patient/motion/recording.h"            // recorded breathing signals
#include "patient/motion/motion.h"               // breathing motion: two velocity fields and their flows
#include "patient/motion/motion_template.h"      // a motion for a patient with a single CT
#include "patient/motion/motion_interface.h"     // the surface along which the two sides slide
#include "patient/package/nifti.h"               // NIfTI images
#include "patient/package/motion_io.h"           // breathing motion as a NIfTI image
#include "patient/package/package.h"             // packages on disk, and the tissue at a point
#include "patient/package/origin.h"              // where a package comes from, as text
#include "patient/package/verdict.h"             // the verdict of `stylet-model check`, beside a package
#include "patient/package/segmentation.h"        // how much of a patient is segmented
#include "patient/package/skin.h"                // the surface as a smooth signed distance
#include "patient/package/tissue_map.h"          // tissue of all voxels, for walks along many paths
#include "patient/planning/planning.h"           // reference paths
#include "patient/planning/paths_json.h"         // reference paths on disk
#include "patient/contrast/vessel_flow.h"        // blood velocity, for Doppler and contrast medium
#include "patient/contrast/contrast.h"           // contrast medium: where the injected volume is
#include "patient/contrast/anaesthetic.h"        // local anaesthetic: its depots, and how numb they make
#include "patient/contrast/duct_space.h"           // the lumen of the ducts, for the guide wire
#include "patient/contrast/contrast_table.h"     // the attenuation that contrast medium adds
