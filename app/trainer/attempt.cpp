#include "app/trainer/attempt.h"

#include "app/trainer/hand.h"

namespace stylet::trainer {

Attempt makeAttempt(const patient::Patient& patient, const Scenario& scenario,
                    const patient::PlannedPath& path, std::uint64_t seed) {
    haptics::SimulationSettings settings;
    settings.patient_from_device = deviceBeside(patient.grid());
    settings.output.model_tangent_n_per_m = haptics::worstTangent(patient.package().tissues, settings.needle);
    settings.scenario_digest = digest(scenario);
    settings.seed = seed;
    return {
        patient, settings,
        scriptHand(scenario, path, patient.package().breathing.signal, settings.patient_from_device, seed)};
}

}  // namespace stylet::trainer
