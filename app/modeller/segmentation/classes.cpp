#include "app/modeller/segmentation/classes.h"

#include <nlohmann/json.hpp>

#include "base/fields.h"

namespace stylet::modeller {

using nlohmann::json;

namespace {

constexpr double kMinPackage_hu = -1024.0, kMaxPackage_hu = 3071.0;  // limits of a package

json toJson(const TissueClass& c) {
    return {{"mean_hu", c.mean_hu}, {"sigma_hu", c.sigma_hu}, {"share", c.share}};
}

}  // namespace

std::string writeClasses(const TissueClasses& c, const patient::Thresholds& t) {
    const json all{{"fat", toJson(c.fat)},
                   {"soft", toJson(c.soft)},
                   {"blood", toJson(c.blood)},
                   {"bone", toJson(c.bone)},
                   {"thresholds_hu",
                    {{"t0", t.t0_hu},
                     {"t1", t.t1_hu},
                     {"t2_sensitive", t.t2_sensitive_hu},
                     {"t2_specific", t.t2_specific_hu}}}};
    return all.dump(2) + "\n";
}

patient::Thresholds parseClasses(const std::string& text) {
    Fields all = parseJson("classes.json", text), hu = all.child("thresholds_hu");
    const auto read = [&](const char* key) { return hu.number(key, kMinPackage_hu, kMaxPackage_hu); };
    const patient::Thresholds t{read("t0"), read("t1"), read("t2_sensitive"), read("t2_specific")};
    if (!(t.t0_hu < t.t1_hu && t.t1_hu < t.t2_sensitive_hu && t.t2_sensitive_hu <= t.t2_specific_hu))
        all.refuse("thresholds_hu", "t0 < t1 < t2_sensitive <= t2_specific does not hold");
    return t;
}

}  // namespace stylet::modeller
