// Internal: colours and legend entries of sheets with CT pictures.
#pragma once

#include <string>

#include "app/report/canvas.h"

namespace stylet::report {

inline constexpr Colour kDark{0.07, 0.08, 0.09}, kWhite{0.94, 0.95, 0.96}, kGrey{0.62, 0.65, 0.68};

// An entry of a legend with its text on the baseline `at`. Returns the x of the next entry.
inline double drawSwatch(Canvas& canvas, Point at, Colour colour, const std::string& text,
                         bool bold = false) {
    const TextStyle style{14, kWhite, Align::left, bold};
    canvas.rectangle(at.x, at.y - 12, 14, 14, colour);
    canvas.text({at.x + 20, at.y}, text, style);
    return at.x + 20 + canvas.textWidth(text, style) + 26;
}

}  // namespace stylet::report
