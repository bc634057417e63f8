#include "scenario/scenario.h"

#include <algorithm>
#include <filesystem>

#include "scenario/headset.h"
#include "scenario/scenario_hands.h"

namespace xrmock {

namespace {

void readSession(const Field& field, const ReadContext& context, Scenario& scenario) {
    std::vector<TargetKey> keys;
    double t_s = -1;
    for (std::size_t i = 0; i < field.arraySize(); ++i) {
        const Field key = field.at(i);
        key.requireObject({"t_s", "state"});
        t_s = keyTime(key, t_s, context);
        keys.push_back({t_s, parseTarget(key.required("state"))});
    }
    if (keys.empty()) return;
    if (!context.is_message && keys.front().t_s > 0) keys.insert(keys.begin(), {0, SessionTarget::focused});
    splice(scenario.session, std::move(keys), context);
}

Offers parseOffers(const Field& field) {
    constexpr XrEnvironmentBlendMode kModes[] = {XR_ENVIRONMENT_BLEND_MODE_OPAQUE,
                                                 XR_ENVIRONMENT_BLEND_MODE_ADDITIVE,
                                                 XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND};
    constexpr std::size_t kMost = 64;
    field.requireObject({"blend_modes", "spaces", "formats"});
    Offers offers;
    if (field.has("blend_modes")) {
        const Field modes = field.at("blend_modes");
        offers.blend_modes.clear();
        for (std::size_t i = 0; i < modes.arraySize(kMost); ++i)
            offers.blend_modes.push_back(kModes[modes.at(i).oneOf({"opaque", "additive", "alpha_blend"})]);
        if (offers.blend_modes.empty()) modes.fail("at least one mode expected");
    }
    if (field.has("spaces")) {
        const Field spaces = field.at("spaces");
        bool* const kinds[] = {&offers.local_floor, &offers.stage, &offers.stationary};
        offers.local_floor = offers.stage = false;
        for (std::size_t i = 0; i < spaces.arraySize(kMost); ++i)
            *kinds[spaces.at(i).oneOf({"local_floor", "stage", "stationary"})] = true;
    }
    if (field.has("formats")) {
        const Field formats = field.at("formats");
        offers.formats.emplace();
        for (std::size_t i = 0; i < formats.arraySize(kMost); ++i)
            offers.formats->push_back(static_cast<std::int64_t>(formats.at(i).integer(1, 2'000'000'000)));
    }
    return offers;
}

// Refuses fields that version 1 does not have.
void refuseNewFields(const Field& root) {
    for (const char* key : {"headset", "events", "assertions", "hands", "offers"})
        if (root.has(key)) root.at(key).fail("only version 2 has this field");
}

}  // namespace

void addRefreshRate(Scenario& scenario, double hz) {
    auto& rates = scenario.refresh_rates_hz;
    const auto place = std::lower_bound(rates.begin(), rates.end(), hz);
    if (place == rates.end() || *place != hz) rates.insert(place, hz);
}

void readTimelines(const Field& root, const ReadContext& context, Scenario& scenario) {
    if (root.has("head")) splice(scenario.head, parsePoses(root.at("head"), context), context);
    if (root.has("controllers")) readControllers(root.at("controllers"), context, scenario);
    if (root.has("hands")) readHands(root.at("hands"), context, scenario);
    if (root.has("session")) readSession(root.at("session"), context, scenario);
    if (root.has("events")) {
        std::vector<Event> events = parseEvents(root.at("events"), context);
        for (const Event& event : events) {
            // A display can change only to a rate that it offers, so offer the event's rate.
            if (const auto* change = std::get_if<RefreshRateChange>(&event.action))
                addRefreshRate(scenario, change->hz);
        }
        scenario.events.insert(scenario.events.end(), events.begin(), events.end());
    }
}

Scenario parseScenario(const std::string& text, const std::string& file_name) {
    const nlohmann::json document = parseJson(text, file_name);
    const Field root{document, file_name, ""};
    root.requireObject({"version", "headset", "refresh_hz", "exit_after_frames", "eyes", "stage_bounds_m",
                        "head", "controllers", "hands", "session", "events", "assertions", "offers"});
    if (root.required("version").integer(1, 2) == 1) refuseNewFields(root);
    const ReadContext context{false, 0, std::filesystem::path(file_name).parent_path().string()};
    Scenario scenario;
    if (root.has("headset")) {
        const std::string headset = root.at("headset").text();
        const bool beside = headset.find('/') != std::string::npos && !headset.starts_with('/');
        loadHeadset(beside ? context.folder + "/" + headset : headset, scenario);
    }
    if (root.has("refresh_hz")) {
        scenario.refresh_hz = root.at("refresh_hz").number(1, 1000);
        if (!root.has("headset")) scenario.refresh_rates_hz.clear();
        addRefreshRate(scenario, scenario.refresh_hz);
    }
    if (root.has("exit_after_frames"))
        scenario.exit_after_frames = root.at("exit_after_frames").integer(1, 1'000'000'000);
    if (root.has("eyes")) {
        root.at("eyes").requireObject(
            {"ipd_m", "recommended_size", "left_fov_rad", "right_fov_rad", "lens", "pictures_through_lens"});
        readEyes(root.at("eyes"), scenario);
    }
    if (root.has("offers")) scenario.offers = parseOffers(root.at("offers"));
    if (root.has("stage_bounds_m")) scenario.stage_bounds_m = root.at("stage_bounds_m").numbers<2>(0.1, 1000);
    readTimelines(root, context, scenario);
    if (root.has("assertions")) scenario.assertions = parseAssertions(root.at("assertions"));
    return scenario;
}

Scenario loadScenario(const std::string& file_name) {
    return parseScenario(readTextFile(file_name), file_name);
}

}  // namespace xrmock
