// Internal: the background and text colours of sheets with CT pictures.
#pragma once

#include "app/report/canvas.h"

namespace stylet::report {

inline constexpr Colour kDark{0.07, 0.08, 0.09}, kWhite{0.94, 0.95, 0.96}, kGrey{0.62, 0.65, 0.68};

}  // namespace stylet::report
