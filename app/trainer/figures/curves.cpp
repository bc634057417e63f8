#include "app/trainer/figures/curves.h"

#include <cstdio>

#include "app/installation.h"
#include "app/trainer/attempt/scenario.h"
#include "app/trainer/figures/two_fasciae.h"
#include "app/trainer/stores/platform_linux.h"
#include "base/folder_linux.h"

namespace stylet::trainer {

int curves(const CurvesOptions& options) {
    requireFolder(options.out, "--out");
    const patient::TissueDefaults table = patient::loadTissueDefaults(
        options.table.empty() ? assetsFolder() / "tissue" / "ptcd.toml" : options.table);
    report::drawTissueCurves(report::tissueCurves(table.tissues, {}), table.tissues,
                             options.out / "tissues.png");

    const Scenario scenario = loadScenario(scenarioFile("two-fasciae"));
    const TwoFasciae phantom = makeTwoFasciae(table.tissues, table.thresholds);
    const FasciaRun reference = playFasciae(phantom.reference, phantom.path, scenario);
    const FasciaRun segmented = playFasciae(phantom.segmented, phantom.path, scenario);
    report::drawComparison(compareFasciae(phantom, reference, segmented), options.out / "two-fasciae.png");
    std::printf("%s\n%s\n", (options.out / "tissues.png").c_str(), (options.out / "two-fasciae.png").c_str());
    return 0;
}

}  // namespace stylet::trainer
