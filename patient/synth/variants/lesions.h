// Painters of diseases and of what surgery leaves behind. They run after the healthy organs.
#pragma once

#include "patient/synth/variants/variant.h"

namespace stylet::patient::synth {

void paintCalcifiedTumour(Painting&);     // in the right lobe under the ribs
void paintNecroticTumour(Painting&);      // large, in the right lobe beside the gallbladder
void paintCysts(Painting&);               // six in the liver; their label stays liver
void paintFissureFat(Painting&);          // thin sheet of fat in the fissure of the venous ligament
void paintAorticPlaque(Painting&);        // in the wall; the label stays aorta
void paintCalcifiedCartilage(Painting&);  // the label stays cartilage
void paintStent(Painting&);               // metal stent in the common duct
void paintScrews(Painting&);              // metal in the first lumbar vertebra
void paintAscites(Painting&);             // fluid around the liver; the label stays visceral fat
void paintEffusion(Painting&);            // fluid behind the lungs; the label stays lung
void paintArms(Painting&);                // arms beside the body: muscle, their bones as inclusions

}  // namespace stylet::patient::synth
