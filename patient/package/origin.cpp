#include "patient/package/origin.h"

#include <algorithm>

namespace stylet::patient {

std::string formatAtlasList(const std::vector<std::string>& names) {
    std::string list;
    for (const std::string& name : names)
        list += (list.empty() ? "atlases: \"" : ", \"") + name + "\"";
    std::ranges::replace_if(list, [](unsigned char c) { return c < 32 || c == 127; }, ' ');
    return list;
}

std::string describeOrigin(const Package& p) {
    return p.provenance + (p.atlases.empty() ? "" : "; " + formatAtlasList(p.atlases));
}

}  // namespace stylet::patient
