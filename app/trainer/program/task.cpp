#include "app/trainer/program/task.h"

#include <random>
#include <set>

#include "app/installation.h"
#include "app/trainer/attempt/reference_path.h"
#include "app/trainer/program/live_input.h"
#include "app/trainer/stores/derived.h"
#include "app/trainer/stores/platform_linux.h"

namespace stylet::trainer {

namespace {

OpenedPatient timedPatient(const AttemptConfig& config, Start& start) {
    start.asked = std::chrono::steady_clock::now();
    OpenedPatient opened = openPatient({config.patient, config.seed, config.spacing_mm / 1000.0,
                                        cacheFolder(), assetsFolder(), config.accept_implausible});
    start.made = opened.made;
    return opened;
}

// An acoustic part exists for the probe. The pictures read it later.
void checkTransducer(const haptics::Instrument& probe, const std::filesystem::path& file) {
    const std::filesystem::path acoustic = assetsFolder() / "ultrasound" / (probe.transducer + ".toml");
    if (!std::filesystem::exists(acoustic))
        throw DataError(file, "transducer", "\"" + probe.transducer + "\" not found: " + acoustic.string());
}

// Replaces instruments of the set by the named ones, one of each kind at most. `needle` may be empty.
void chooseInstruments(haptics::InstrumentSet& set, const std::string& needle,
                       const std::vector<std::string>& others) {
    std::set<haptics::InstrumentKind> chosen;
    const auto choose = [&](const std::string& name, bool must_be_needle) {
        const std::filesystem::path file = assetFile("instrument", name);
        haptics::Instrument one = haptics::loadInstrument(file);
        const std::string kind(enumName(haptics::kInstrumentKindNames, one.kind));
        haptics::Instrument* const place = haptics::findInstrument(set, one.kind);
        if (must_be_needle && one.kind != haptics::InstrumentKind::needle)
            throw DataError(file, "kind", "is no needle; \"stylet instruments\" lists the needles");
        if (!chosen.insert(one.kind).second)
            throw DataError(file, "kind", "is a second " + kind + ", besides \"" + place->name + "\"");
        if (one.kind == haptics::InstrumentKind::probe) checkTransducer(one, file);
        *place = std::move(one);
    };
    if (!needle.empty()) choose(needle, true);
    for (const std::string& name : others)
        choose(name, false);
}

}  // namespace

Task::Task(const AttemptConfig& config, Retry* retry, Start& start)
    : scenario(loadScenario(scenarioFile(config.scenario.empty() ? "demo" : config.scenario))),
      opened(timedPatient(config, start)),
      patient(opened.package),
      other(loadOtherSegmentation(patient, config.full)),
      path(retry ? retry->record.info.path
                 : referencePath(patient, opened.folder, config.path, scenario.course, &start.made)),
      field(operativeField(patient, path, config.startRules())) {
    patient_digest = patient::digest(opened.package);
    make_touch = [digest = patient_digest, &start](const patient::Patient& on) {
        return loadOrMakeTouchMap(on, digest, cacheFolder() / "derived", &start.made);
    };
    if (retry) {
        scenario.course = recordedCourse(retry->record.info);
        scenario.patient_case = recordedCase(retry->record.info);
        checkRetry(*retry, patient, make_touch);
    } else {
        // A live exam's case must not be known from an earlier attempt with the same seed.
        const bool anew = isLive(config) && config.difficulty == training::Difficulty::exam;
        drawCase(scenario, anew ? std::random_device{}() : config.seed);
    }
    start.patient = std::chrono::steady_clock::now();
}

void loadInstruments(AttemptConfig& config, const Scenario& scenario) {
    haptics::InstrumentSet& set = config.instruments;
    set = {};
    std::vector<std::string> defaults;
    visitInstruments(set, [&](const haptics::Instrument& one) { defaults.push_back(one.name); });
    chooseInstruments(set, {}, defaults);
    // The scenario's needle may be missing if the user has named another one.
    chooseInstruments(set, config.needle_name.empty() ? scenario.needle : "", scenario.instruments);
    chooseInstruments(set, config.needle_name, config.instrument_names);
    config.tools = {};
    equip(config.tools, set);
}

}  // namespace stylet::trainer
