#include "app/modeller/build/classes.h"

namespace stylet::modeller {

TissueClasses classesOf(const patient::CtVolume&, const Mask&) {
    return {};
}

patient::Thresholds thresholdsOf(const TissueClasses&) {
    return {};
}

}  // namespace stylet::modeller
