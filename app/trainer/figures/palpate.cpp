#include "app/trainer/figures/palpate.h"

#include <cstdio>

#include "app/installation.h"
#include "app/report/palpation.h"
#include "app/trainer/stores/platform_linux.h"
#include "base/folder_linux.h"
#include "base/parallel.h"

namespace stylet::trainer {

int palpate(const PalpateOptions& options) {
    requireFolder(options.out, "--out");
    const OpenedPatient opened = openPatient(options.source);
    const patient::Patient patient(opened.package);
    const int threads = processorCount();
    const patient::Skin skin = patient::makeSkin(patient, threads);
    const haptics::TouchMap touch = haptics::makeTouchMap(patient, skin, threads);
    report::PalpationSettings settings;
    settings.breathing = options.breathing;
    const report::PalpationMap map = report::palpate(patient, skin, touch, settings);
    if (map.spots.empty()) throw DataError(opened.folder, "labels", "no liver: the flank is not known");

    const std::string breath = options.breathing ? ", breathing" : ", breath held";
    report::drawPalpation(map, opened.package.name + breath, options.out / "palpation.png");
    report::writePalpationCsv(map, options.out / "palpation.csv");
    std::printf("%s%s\n", opened.package.name.c_str(), breath.c_str());
    std::printf("  stiffness against the rib mask: Pearson r %.2f\n", map.pearson);
    std::printf("  middle of a rib %.3f N/mm, of a gap %.3f: %.1f to 1 (all spots: %.1f)\n",
                1e-3 * map.rib_n_per_m, 1e-3 * map.gap_n_per_m, map.ribOverGap(),
                map.rib_over_gap_everywhere);
    std::printf("  %s\n", (options.out / "palpation.png").string().c_str());
    return 0;
}

}  // namespace stylet::trainer
