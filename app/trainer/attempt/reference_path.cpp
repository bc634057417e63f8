#include "app/trainer/attempt/reference_path.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

#include "app/records/replay.h"
#include "app/trainer/attempt/retry.h"
#include "app/trainer/session/session.h"
#include "app/trainer/stores/console.h"
#include "app/trainer/stores/patient_source.h"
#include "app/training/surroundings.h"
#include "base/text.h"

namespace stylet::trainer {

using patient::PlannedPath;

namespace {

constexpr const char* kOption = "--path";

// Returns the tick in which the recorded needle cut the target duct.
haptics::TickOutput targetCut(const patient::Patient& patient, const std::filesystem::path& folder) {
    const records::Record record = records::loadRecord(folder);
    Session session(patient, record.info.path, {}, 0.0, nullptr, record.header.settings.dt_s);
    const records::ReplayResult again =
        records::replay(patient, record,
                        [&](const haptics::TickInput& input, const haptics::TickOutput& output,
                            const haptics::NeedleEvents& events) { session.update(input, output, events); });
    if (!again.equal())
        throw DataError(folder, kOption,
                        "replaying the attempt gives another result; it was recorded by another version");
    if (!session.log().target_cut)
        throw DataError(folder, kOption, "the attempt's needle did not reach the target duct");
    return *session.log().target_cut;
}

PlannedPath needleTrack(const haptics::TickOutput& cut, const patient::Patient& patient) {
    const patient::MotionModel& motion = patient.package().motion;
    const Vec3 tip = cut.patient_from_needle.position_m,
               to_hub = cut.patient_from_needle.direction({0.0, 0.0, 1.0});
    PlannedPath path;
    path.entry_reference_m = referenceFromDeformed(motion, cut.breath, tip + to_hub * cut.depth_m);
    path.target_reference_m = referenceFromDeformed(motion, cut.breath, tip);
    path.entry_m = deformedFromReference(motion, path.breath, path.entry_reference_m);
    path.target_m = deformedFromReference(motion, path.breath, path.target_reference_m);
    return path;
}

}  // namespace

const PlannedPath& pathForWire(const patient::Patient& patient, const std::vector<PlannedPath>& paths) {
    constexpr double kEasy_rad = 1.05;
    const PlannedPath* best = nullptr;
    double best_rad = std::numeric_limits<double>::infinity();
    for (const PlannedPath& path : paths) {
        const std::optional<Vec3> duct = training::ductDirection(patient, path.target_reference_m);
        if (!duct) continue;
        const Vec3 inward = glm::normalize(path.target_reference_m - path.entry_reference_m);
        const double rad = std::acos(std::min(1.0, std::fabs(glm::dot(inward, *duct))));
        if (rad <= kEasy_rad) return path;
        if (rad < best_rad) best = &path, best_rad = rad;
    }
    return best ? *best : paths.front();
}

PlannedPath referencePath(const patient::Patient& patient, const std::filesystem::path& patient_folder,
                          const std::string& asked, training::Course course, Made* made) {
    if (const auto number = parseNumber<std::size_t>(asked.empty() ? "1" : asked)) {
        const std::vector<PlannedPath> paths = goodPaths(patient, patient_folder, patient::Surrogate{}, made);
        if (*number < 1 || *number > paths.size())
            throw DataError(patient_folder / "paths.json", kOption,
                            fmt::format("there is no path {}: the patient has 1 to {}", asked, paths.size()));
        if (asked.empty() && course == training::Course::drainage) return pathForWire(patient, paths);
        return paths[*number - 1];
    }
    PlannedPath path = needleTrack(targetCut(patient, asked), patient);
    if (!ratePath(patient, {}, path))
        printMessage(fmt::format("the path of {} is not one that the planner would propose", asked));
    return path;
}

}  // namespace stylet::trainer
