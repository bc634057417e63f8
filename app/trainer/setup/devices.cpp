#include "app/trainer/setup/devices.h"

#include <fmt/core.h>
#include <cmath>
#include <nlohmann/json.hpp>

namespace stylet::trainer {

using haptics::DeviceKind;
using haptics::DeviceOptions;
using haptics::DeviceProfile;
using haptics::FoundDevice;
using json = nlohmann::ordered_json;

namespace {

json known(double value) {
    return std::isfinite(value) ? json(value) : json(nullptr);
}

json limitsJson(const DeviceProfile& p) {
    return {{"force_peak_n", known(p.force_peak_n)},
            {"force_continuous_n", known(p.force_continuous_n)},
            {"stiffness_n_per_m", known(p.stiffness_n_per_m)},
            {"rate_hz", known(p.rate_hz)},
            {"resolution_m", known(p.resolution_m)},
            {"workspace_radius_m", known(p.workspace_radius_m)},
            {"force_axes", p.force_axes},
            {"torque_axes", p.torque_axes},
            {"senses_rotation", p.senses_rotation},
            {"has_dead_man", p.has_dead_man},
            {"force_calibrated", p.force_calibrated},
            {"source", p.source}};
}

json kindJson(const DeviceKind& kind, const std::vector<FoundDevice>& found, const DeviceOptions& options) {
    json list = json::array();
    for (const FoundDevice& device : found)
        if (device.kind == kind.name)
            list.push_back({{"place", device.place}, {"what", device.what}, {"problem", device.problem}});
    const bool built = kind.missing == nullptr;
    return {{"name", kind.name},
            {"what", kind.what},
            {"built", built},
            {"missing", built ? "" : kind.missing},
            {"limits", built ? limitsJson(haptics::deviceProfile(kind.name, options)) : json(nullptr)},
            {"found", list}};
}

std::string quantity(double value, double scale, fmt::format_string<double> format) {
    return std::isfinite(value) ? fmt::format(format, value * scale) : "";
}

std::string limitsText(const DeviceProfile& p) {
    if (p.force_axes == 0) return "input only; " + quantity(p.workspace_radius_m, 1e3, "reach {:.0f} mm");
    std::string text;
    for (const std::string& part :
         {quantity(p.force_peak_n, 1.0, "{:.1f} N"), quantity(p.stiffness_n_per_m, 1.0, "{:.0f} N/m"),
          quantity(p.workspace_radius_m, 1e3, "radius {:.0f} mm"),
          quantity(p.resolution_m, 1e6, "{:.0f} um a count"),
          std::string(p.senses_rotation ? "" : "no orientation"),
          std::string(p.force_calibrated ? "" : "force not calibrated")})
        if (!part.empty()) text += (text.empty() ? "" : ", ") + part;
    return (text.empty() ? "not known yet" : text) + " (" + p.source + ")";
}

std::string kindText(const DeviceKind& kind, const std::vector<FoundDevice>& found,
                     const DeviceOptions& options) {
    std::string text = std::string(kind.name) + ": " + kind.what + "\n";
    if (kind.missing) return text + "  not in this build: install " + kind.missing + " and build again\n";
    bool any = false;
    for (const FoundDevice& device : found) {
        if (device.kind != kind.name) continue;
        any = true;
        text += "  " + device.place + ": " + device.what + ": " +
                (device.problem.empty() ? "can be used" : device.problem) + "\n";
    }
    if (!any) text += "  not there\n";
    return text + "  limits: " + limitsText(haptics::deviceProfile(kind.name, options)) + "\n";
}

}  // namespace

std::string describeDevices(const DeviceOptions& options, bool as_json) {
    const std::vector<FoundDevice> found = haptics::findDevices(options);
    json list = json::array();
    std::string text;
    for (const DeviceKind& kind : haptics::deviceKinds()) {
        if (as_json)
            list.push_back(kindJson(kind, found, options));
        else
            text += kindText(kind, found, options);
    }
    return as_json ? json{{"devices", list}}.dump(2, ' ', false, json::error_handler_t::replace) + "\n"
                   : text;
}

}  // namespace stylet::trainer
