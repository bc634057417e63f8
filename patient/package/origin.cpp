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

std::string_view synthVariants(std::string_view provenance) {
    constexpr std::string_view kOption = " --variant ";
    const std::size_t option = provenance.find(kOption);
    if (option == std::string_view::npos) return {};
    provenance.remove_prefix(option + kOption.size());
    return provenance.substr(0, provenance.find_first_of(" ;"));
}

std::string describeOrigin(const Package& p) {
    return p.provenance + (p.atlases.empty() ? "" : "; " + formatAtlasList(p.atlases));
}

}  // namespace stylet::patient
