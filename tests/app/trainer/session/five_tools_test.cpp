// Runs the whole procedure on layers with known borders, one tool after the other, through the loops of an
// attempt.
#include <gtest/gtest.h>

#include <set>

#include "app/records/replay.h"
#include "tests/app/trainer/phantom_attempt.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

using haptics::NeedleEventKind;
using haptics::Tool;
using patient::Tissue;

Scenario fiveTools() {
    return loadScenario(test::assets() / "scenarios" / "five-tools.toml");
}

TEST(FiveTools, PalpateParkInciseSnapInAndPuncture) {
    const test::TempFolder folder;
    const patient::Package package = test::ductPhantom();
    const patient::Patient patient(package);
    const Scenario scenario = fiveTools();
    const Attempt attempt = makeAttempt(patient, scenario, test::ductPath(), 1);
    records::RecordInfo info;
    info.path = test::ductPath();
    records::RecordWriter writer(folder / "record", {patient::digest(package), attempt.simulation}, info);
    Session session(patient, test::ductPath(), scenario.moments, scenario.approach_distance_m, &writer);
    runFast(attempt, session, nullptr, 0.0, {});
    writer.finish();
    const SessionLog& log = session.log();
    EXPECT_TRUE(log.target_hit());
    EXPECT_EQ(log.faults, 0u);
    for (const haptics::EventRecord& record : log.punctures) {
        if (record.event.border.to == Tissue::skin) {
            EXPECT_EQ(record.event.kind, NeedleEventKind::entry) << "through the incision";
        }
    }
    EXPECT_EQ(log.lateral_cut_m, 0.0);  // the guide's rail absorbs the tremor

    // A replay of the record gives the same hash. Each tool has produced a force.
    const records::Record record = records::loadRecord(folder / "record");
    std::set<Tool> felt;
    bool parked = false, guided = false;
    const records::ReplayResult again = records::replay(
        patient, record,
        [&](const haptics::TickInput&, const haptics::TickOutput& out, const haptics::NeedleEvents&) {
            if (glm::length(out.tool_force.force_n) > 0.02) felt.insert(out.tool);
            parked = parked || out.probe_parked;
            guided = guided || (out.needle_in_guide && out.tissue == Tissue::duct);
        });
    EXPECT_TRUE(again.equal());
    EXPECT_EQ(again.state_hash, log.state_hash);
    for (const Tool tool : {Tool::finger, Tool::probe, Tool::scalpel, Tool::needle})
        EXPECT_EQ(felt.count(tool), 1u) << haptics::kToolNames[std::size_t(tool)];
    EXPECT_TRUE(parked);
    EXPECT_TRUE(guided);
}

}  // namespace
}  // namespace stylet::trainer
