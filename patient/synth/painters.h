// The painters in call order: from the skin inwards, then organs and trees. Each painter overwrites only
// the labels that it may replace.
#pragma once

#include "patient/synth/canvas.h"
#include "patient/synth/trees.h"

namespace stylet::patient::synth {

inline constexpr IdSet kCavity = only(Id::visceralFat);  // before any organ

void paintWall(Canvas&,
               const Anatomy&);  // skin, fat, muscle; fills the inside of the fascia with visceral fat
void paintFascia(Canvas&);       // one voxel thick, around the cavity; 6-separating
void paintSpine(Canvas&, const Anatomy&);
void paintRibs(Canvas&, const Anatomy&);    // ribs 5-12, costal cartilages, sternum
void paintThorax(Canvas&, const Anatomy&);  // diaphragm, lungs, heart
void paintGreatVessels(Canvas&, const Anatomy&);
void paintLiver(Canvas&, const Anatomy&);  // with kidneys and gallbladder, which indent it
void paintTrees(Canvas&, const HepaticTrees&);
void paintSolidOrgans(Canvas&, const Anatomy&);  // tumour, spleen, pancreas, arteries and renal veins
void paintBowel(Canvas&, const Anatomy&);        // oesophagus, stomach, duodenum, colon, small bowel, gas
// Keeps one piece per organ. Fragments that overlaps have cut off take the label of their surroundings.
void removeIslands(Canvas&);

}  // namespace stylet::patient::synth
