// What an attempt is about: patient, scenario, reference path and instruments.
#pragma once

#include <cstdint>
#include <optional>

#include "app/trainer/attempt/attempt.h"
#include "app/trainer/attempt/config.h"
#include "app/trainer/attempt/retry.h"
#include "app/trainer/attempt/scenario.h"
#include "app/trainer/session/force_comparison.h"
#include "app/trainer/stores/patient_source.h"
#include "app/trainer/stores/start.h"
#include "patient/patient.h"

namespace stylet::trainer {

// The patient refers to its package.
struct Task {
    // If `retry` is not null, checks that attempt against the patient. `start` must outlive this object.
    Task(const AttemptConfig&, Retry* retry, Start& start);
    Task(const Task&) = delete;
    Task& operator=(const Task&) = delete;

    Scenario scenario;
    OpenedPatient opened;
    patient::Patient patient;
    std::optional<OtherSegmentation> other;
    patient::PlannedPath path;
    OperativeField field;  // that room, device and pictures are arranged around
    std::uint64_t patient_digest = 0;
    MakeTouch make_touch;
};

// Loads the instruments into the configuration: of each kind that of the command line, else that of the
// scenario, else the default. Throws DataError.
void loadInstruments(AttemptConfig&, const Scenario&);

}  // namespace stylet::trainer
