#include "app/trainer/figures/looks.h"

#include <algorithm>
#include <cstdio>
#include <glm/geometric.hpp>

#include "app/installation.h"
#include "app/report/classes.h"
#include "app/report/film.h"
#include "app/trainer/attempt/hand.h"
#include "app/trainer/stores/platform_linux.h"
#include "app/trainer/view/pictures.h"
#include "base/folder_linux.h"

namespace stylet::trainer {

namespace {

constexpr double kCloseUp_m = 0.10, kAtArmsLength_m = 0.25;
constexpr double kShown_m = 0.030;  // needle depth under the skin, about halfway to the target

struct Named {
    std::string caption;
    StereoShot shot;
};

// Wounds of a wrong puncture: an incision, the needle's hole beside it, and the blood that a vein loses in
// half a minute.
std::vector<Wound> woundsAt(const patient::PlannedPath& path) {
    const Vec3 axis = glm::normalize(path.target_m - path.entry_m);
    const Vec3 along = glm::normalize(glm::cross(axis, {0.0, 1.0, 0.0}));
    const Vec3 beside = path.entry_reference_m + 0.014 * along;
    return {{WoundKind::incision, path.entry_reference_m, 0.003, along},
            {WoundKind::puncture, beside, NeedleShape().radius_m()},
            {WoundKind::blood, beside, 0.007, {0.0, -1.0, 0.0}}};
}

// Selects some of the paths, including the best and the worst. Rescales their quality to 0 (worst) to 1
// (best).
std::vector<patient::PlannedPath> spread(const std::vector<patient::PlannedPath>& paths) {
    constexpr std::size_t kShownPaths = 48;
    const std::size_t count = std::min(paths.size(), kShownPaths);
    const double best = paths.front().quality, range = best - paths.back().quality;
    std::vector<patient::PlannedPath> few;
    for (std::size_t i = 0; i < count; ++i) {
        few.push_back(paths[count > 1 ? i * (paths.size() - 1) / (count - 1) : 0]);
        few.back().quality = range > 0.0 ? 1.0 - (best - few.back().quality) / range : 1.0;
    }
    return few;
}

std::vector<Named> makeShots(const std::vector<patient::PlannedPath>& paths) {
    const patient::PlannedPath& path = paths.front();
    const Vec3 axis = glm::normalize(path.target_m - path.entry_m);
    const Pose needle = needlePose(path.entry_m + kShown_m * axis, axis);
    StereoShot closed{.closed = true, .patient_from_needle = needle}, reveal{.patient_from_needle = needle};
    StereoShot near = closed, section = closed, wounds{.closed = true}, slow = reveal;
    near.distance_m = kAtArmsLength_m;
    section.section = true;
    wounds.distance_m = kCloseUp_m;
    wounds.wounds = woundsAt(path);
    slow.distance_m = kCloseUp_m;
    StereoShot planned{.paths = spread(paths)};
    StereoShot room{.closed = true, .across_the_room = true, .patient_from_needle = needle};
    return {{"closed", closed},
            {"reveal", reveal},
            {"closed, 25 cm away", near},
            {"closed, cut at the entry", section},
            {"an incision and a wrong puncture, 10 cm away", wounds},
            {"reveal, 10 cm away: the slow case", slow},
            {"reference paths, coloured by quality", planned},
            {"across the room", room}};
}

}  // namespace

int looks(const LooksOptions& options) {
    requireFolder(options.out, "--out");
    const OpenedPatient opened = openPatient(options.source);
    const patient::Patient patient(opened.package);
    const std::vector<patient::PlannedPath> paths = goodPaths(patient, opened.folder, patient::Surrogate{});
    const patient::PlannedPath& path = paths.front();
    report::drawClasses(patient, path.target_reference_m,
                        opened.package.name + ", tissue classes at the target's height",
                        options.out / "classes.png");
    std::string why_not;
    const auto view = openStereo(patient, path, assetsFolder(), why_not);
    if (!view) throw EnvironmentError("no pictures can be drawn: " + why_not);
    std::vector<report::FilmFrame> frames;
    for (Named named : makeShots(paths)) {
        named.shot.pixels = options.pixels;
        std::array<EyePicture, 2> eyes = view->draw(named.shot);
        frames.push_back(report::sideBySide(filmFrame(std::move(eyes[0]), named.caption),
                                            filmFrame(std::move(eyes[1]), {})));
    }
    report::writeFilm(frames, opened.package.name + ", left and right eye", options.out, "looks");
    std::printf("%s on %s\n", (options.out / "looks.png").c_str(), view->gpu.c_str());
    return 0;
}

}  // namespace stylet::trainer
