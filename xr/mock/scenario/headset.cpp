#include "scenario/headset.h"

#include <dlfcn.h>

#include <algorithm>
#include <filesystem>
#include <numbers>

#include "scenario/profiles.h"

namespace xrmock {

namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;

// The folder of the headset files. It is beside the library, both in the build tree and installed.
std::filesystem::path headsetFolder() {
    Dl_info library{};
    if (dladdr(reinterpret_cast<const void*>(&loadHeadset), &library) == 0 || library.dli_fname == nullptr)
        return "headsets";
    return std::filesystem::path(library.dli_fname).parent_path() / "headsets";
}

// Left, right, up, down.
XrFovf parseFov(const Field& field, double rad_per_unit) {
    constexpr double kLimitRad = 1.55;  // just below a right angle
    const auto angles = field.numbers<4>(-kLimitRad / rad_per_unit, kLimitRad / rad_per_unit);
    if (angles[0] >= angles[1] || angles[3] >= angles[2]) field.fail("left < right and down < up expected");
    return {static_cast<float>(angles[0] * rad_per_unit), static_cast<float>(angles[1] * rad_per_unit),
            static_cast<float>(angles[2] * rad_per_unit), static_cast<float>(angles[3] * rad_per_unit)};
}

void readRefreshRates(const Field& field, Scenario& scenario) {
    std::vector<double> rates;
    for (std::size_t i = 0; i < field.arraySize(32); ++i) {
        const Field rate = field.at(i);
        rates.push_back(rate.number(1, 1000));
        if (i > 0 && rates[i] <= rates[i - 1]) rate.fail("more than the rate before expected");
    }
    if (rates.empty()) field.fail("at least one rate expected");
    scenario.refresh_rates_hz = std::move(rates);
}

}  // namespace

void readEyes(const Field& field, Scenario& scenario) {
    if (field.has("ipd_m")) scenario.ipd_m = field.at("ipd_m").number(0, 1);
    if (field.has("recommended_size")) {
        const Field size = field.at("recommended_size");
        if (size.arraySize() != 2) size.fail("2 numbers expected");
        scenario.width = static_cast<std::uint32_t>(size.at(0).integer(1, kMaxImageSize));
        scenario.height = static_cast<std::uint32_t>(size.at(1).integer(1, kMaxImageSize));
    }
    if (field.has("left_fov_rad")) scenario.eye_fov[0] = parseFov(field.at("left_fov_rad"), 1);
    if (field.has("right_fov_rad")) scenario.eye_fov[1] = parseFov(field.at("right_fov_rad"), 1);
    if (field.has("lens")) scenario.lens = parseLens(field.at("lens"));
    if (field.has("pictures_through_lens"))
        scenario.pictures_through_lens = field.at("pictures_through_lens").boolean();
}

void loadHeadset(const std::string& name_or_file, Scenario& scenario) {
    const bool is_file = name_or_file.find('/') != std::string::npos;
    const std::string file = is_file ? name_or_file : (headsetFolder() / (name_or_file + ".json")).string();
    const nlohmann::json document = parseJson(readTextFile(file), file);
    const Field root{document, file, ""};
    root.requireObject({"version", "name", "source", "recommended_size", "left_fov_deg", "right_fov_deg",
                        "ipd_m", "eye_turn_deg", "refresh_rates_hz", "refresh_hz", "tracking_extent_m",
                        "lens"});
    root.required("version").integer(1, 1);
    scenario.system_name = root.required("name").text();
    if (scenario.system_name.empty() || scenario.system_name.size() >= XR_MAX_SYSTEM_NAME_SIZE)
        root.at("name").fail("1 to 255 bytes expected");
    if (root.has("source")) root.at("source").text();
    readEyes(root, scenario);
    if (root.has("left_fov_deg")) {
        const XrFovf left = parseFov(root.at("left_fov_deg"), kRadPerDeg);
        scenario.eye_fov = {left, {-left.angleRight, -left.angleLeft, left.angleUp, left.angleDown}};
    }
    if (root.has("right_fov_deg")) scenario.eye_fov[1] = parseFov(root.at("right_fov_deg"), kRadPerDeg);
    if (root.has("eye_turn_deg"))
        scenario.eye_turn_rad = root.at("eye_turn_deg").number(-45, 45) * kRadPerDeg;
    if (root.has("refresh_rates_hz")) readRefreshRates(root.at("refresh_rates_hz"), scenario);
    scenario.refresh_hz = scenario.refresh_rates_hz.back();
    if (root.has("refresh_hz")) {
        scenario.refresh_hz = root.at("refresh_hz").number(1, 1000);
        if (std::find(scenario.refresh_rates_hz.begin(), scenario.refresh_rates_hz.end(),
                      scenario.refresh_hz) == scenario.refresh_rates_hz.end()) {
            root.at("refresh_hz").fail("one of refresh_rates_hz expected");
        }
    }
    if (root.has("tracking_extent_m"))
        scenario.stage_bounds_m = root.at("tracking_extent_m").numbers<2>(0.1, 1000);
}

}  // namespace xrmock
