// An attempt's result, and its record as the trainer writes it.
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "app/records/record.h"
#include "app/records/store.h"

namespace stylet::test {

// One metric value is infinite and one is NaN. Every other number differs from its default.
inline records::AttemptResult someResult() {
    records::AttemptResult r{
        true,
        87.5,
        12345,
        {{"clearance", "least clearance", "mm", std::numeric_limits<double>::infinity(), 10.0, 12.0},
         {"angle", "duct angle", "deg", std::nan(""), 0.0, 8.0}}};
    r.score_version = 3;
    r.steps = {"advance to the duct", {"find the gap", "find the duct"}, 6, 1};
    r.captures = {{"duct", 41000, 0.0731}};
    r.punctures = {{"duct", "cut", "bile ducts", 41000, 0.0725, 1.0 / 3.0, 1.25, 0.5}};
    r.peak_force_n = 2.5, r.lateral_cut_m = 0.0011;
    r.dose = {3.5, 52, 0.0021, 1.5e-5, 7.25};
    r.contrast = {"duct", 1.5, 2.5, 0.25, 0.125, 0.0625, 0.03125, 12.5, -INFINITY, true};
    r.force_truth =
        records::ForceTruthResult{"partial", 2, {10, 0.5, 0.25, 1.5, 0.04}, {20, 0.25, 0.5, 2.5, 0.05}};
    r.haptics.rate_hz = 999.5, r.haptics.max_step_us = 81.5;
    r.haptics.ticks = 12346, r.haptics.late_ticks = 3, r.haptics.page_faults = 1;
    r.haptics.faults = 5, r.haptics.fault_names = "late tick", r.haptics.flights = 2,
    r.haptics.flights_lost = 1;
    r.haptics.contact_ticks = 500, r.haptics.felt_share = 0.125, r.haptics.peak_n = 0.75,
    r.haptics.rms_n = 0.1;
    return r;
}

// What the trainer knows when it begins the record of a stored attempt.
inline records::RecordInfo recordInfo(const records::StoredAttempt& stored) {
    records::RecordInfo info;
    info.id = stored.id, info.trainee = stored.info.trainee, info.started_utc = stored.started_utc;
    info.program_version = stored.info.program_version;
    info.device = stored.info.device, info.clock = "virtual", info.difficulty = stored.info.difficulty;
    info.registration_rms_m = stored.info.registration_rms_m;
    info.patient_name = stored.info.patient, info.scenario = stored.info.scenario;
    info.seed = stored.info.seed, info.gain = stored.info.device_gain;
    return info;
}

inline records::RecordWriter beginRecord(const records::StoredAttempt& stored) {
    records::RecordHeader header;
    header.package_digest = stored.info.patient_digest;
    header.settings.dt_s = stored.info.dt_s;
    return {stored.folder / "record", header, recordInfo(stored)};
}

// Writes the record of an attempt with `ticks` ticks without finishing it, as a killed program leaves it.
inline void writeUnfinishedRecord(const records::StoredAttempt& stored, std::uint64_t ticks,
                                  const std::vector<records::EventRow>& events = {}) {
    records::RecordWriter writer = beginRecord(stored);
    for (std::uint64_t tick = 1; tick <= ticks; ++tick)
        writer.add({}, tick, tick);
    writer.addEvents(events);
}

// Writes the record of an attempt that was begun, and finishes it.
inline void finish(records::Store& store, const std::string& id,
                   const records::AttemptResult& result = someResult(),
                   const std::vector<records::EventRow>& events = {}, std::uint64_t ticks = 0) {
    records::RecordWriter writer = beginRecord(store.attempt(id));
    for (std::uint64_t tick = 1; tick <= ticks; ++tick)
        writer.add({}, tick, tick);
    writer.addEvents(events);
    writer.finish(result);
    store.finish(id);
}

}  // namespace stylet::test
