#include "app/trainer/attempt/reference_path.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "app/records/replay.h"
#include "app/trainer/attempt/retry.h"
#include "app/trainer/session/session.h"
#include "app/trainer/stores/console.h"
#include "app/trainer/stores/patient_source.h"
#include "base/text.h"
#include "haptics/haptics.h"

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

double wireReach_m(const patient::DuctSpace& ducts, const PlannedPath& path) {
    constexpr double kPush_m = 1e-4;
    constexpr int kMaxPushes = 1000, kMaxStopped = 60;  // a wire that does not move for 6 mm is stopped
    const Vec3 inward = glm::normalize(path.target_reference_m - path.entry_reference_m);
    const haptics::WireBase base{path.target_reference_m, inward};
    const haptics::WireSettings settings;
    haptics::WireState wire;
    double reach_m = 0.0;
    int stopped = 0;
    for (int n = 0; n < kMaxPushes && stopped < kMaxStopped && reach_m < kWireReach_m; ++n) {
        haptics::stepWire(wire, settings, ducts, base, kPush_m);
        if (std::isfinite(wire.pierced_m)) break;
        const bool in_duct = isInTargetDuct(ducts, haptics::wireTip(wire, base));
        const double now_m = in_duct ? wire.fed_m - wire.solid_m : 0.0;
        stopped = now_m > reach_m ? 0 : stopped + 1;
        reach_m = std::max(reach_m, now_m);
    }
    return reach_m;
}

double sureWireReach_m(const patient::DuctSpace& ducts, const PlannedPath& path) {
    constexpr double kBeside_m = 0.001;
    const Vec3 axis = glm::normalize(path.target_reference_m - path.entry_reference_m);
    const Vec3 other = std::fabs(axis.y) < 0.9 ? Vec3(0.0, 1.0, 0.0) : Vec3(1.0, 0.0, 0.0);
    const Vec3 across = glm::normalize(glm::cross(axis, other)), third = glm::cross(axis, across);
    double reach_m = kWireReach_m;
    for (const Vec3& beside : {Vec3(0.0), axis, across, -across, third, -third}) {
        PlannedPath shifted = path;
        shifted.entry_reference_m += kBeside_m * beside, shifted.target_reference_m += kBeside_m * beside;
        reach_m = std::min(reach_m, wireReach_m(ducts, shifted));
        if (reach_m == 0.0) break;
    }
    return reach_m;
}

const PlannedPath& pathForWire(const patient::DuctSpace& ducts, const std::vector<PlannedPath>& paths) {
    constexpr std::size_t kMaxTried = 50;
    std::size_t best = 0;
    double best_m = -kWireReach_m;
    for (std::size_t i = 0; i < std::min(paths.size(), kMaxTried) && best_m < kSureReach_m; ++i) {
        const double reach_m = wireReach_m(ducts, paths[i]);
        // A path from which the wire goes far from the target comes before all others.
        const double value_m =
            reach_m < kWireReach_m ? reach_m - kWireReach_m : sureWireReach_m(ducts, paths[i]);
        if (value_m > best_m) best = i, best_m = value_m;
    }
    return paths[best];
}

PlannedPath referencePath(const patient::Patient& patient, const std::filesystem::path& patient_folder,
                          const std::string& asked, training::Course course, Made* made) {
    if (const auto number = parseNumber<std::size_t>(asked.empty() ? "1" : asked)) {
        const std::vector<PlannedPath> paths = goodPaths(patient, patient_folder, patient::Surrogate{}, made);
        if (*number < 1 || *number > paths.size())
            throw DataError(patient_folder / "paths.json", kOption,
                            fmt::format("there is no path {}: the patient has 1 to {}", asked, paths.size()));
        if (asked.empty() && course == training::Course::drainage)
            return pathForWire(patient::makeDuctSpace(patient), paths);
        return paths[*number - 1];
    }
    PlannedPath path = needleTrack(targetCut(patient, asked), patient);
    if (!ratePath(patient, {}, path))
        printMessage(fmt::format("the path of {} is not one that the planner would propose", asked));
    return path;
}

}  // namespace stylet::trainer
