// The painters, in the order in which they are called: from the skin inwards, then the organs, then the
// trees. Each paints onto the labels it may replace and leaves the rest alone.
#pragma once

#include "patient/synth/canvas.h"
#include "patient/synth/trees.h"

namespace stylet::patient::synth {

inline constexpr IdSet kCavity = only(Id::visceralFat);  // before any organ

void paintWall(Canvas&,
               const Anatomy&);  // skin, fat, muscle; everything inside the fascia becomes visceral fat
void paintFascia(Canvas&);       // the one-voxel surface around the cavity, 6-separating
void paintSpine(Canvas&, const Anatomy&);
void paintRibs(Canvas&, const Anatomy&);    // ribs 5-12, costal cartilages, sternum
void paintThorax(Canvas&, const Anatomy&);  // diaphragm, lungs, heart
void paintGreatVessels(Canvas&, const Anatomy&);
void paintLiver(Canvas&, const Anatomy&);  // with the kidneys and the gallbladder that dent it
void paintTrees(Canvas&, const HepaticTrees&);
void paintSolidOrgans(Canvas&, const Anatomy&);  // tumour, spleen, pancreas, arteries and renal veins
void paintBowel(Canvas&, const Anatomy&);        // oesophagus, stomach, duodenum, colon, small bowel, gas
// One piece per organ: what overlaps have cut off becomes what surrounds it.
void removeIslands(Canvas&);

}  // namespace stylet::patient::synth
