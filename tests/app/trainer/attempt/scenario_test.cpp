#include "app/trainer/attempt/scenario.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <set>

#include "patient/patient.h"
#include "tests/app/trainer/assets.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

constexpr const char* kGood = R"(
name = "good"
tool = "finger"
moments = ["approach", "duct"]
approach_distance_mm = 20.0
course = "drainage"
[breath]
period_s = 5.0
period_jitter = 0.1
depth_jitter = 0.12
sighs = 0.02
coughs = 0.01
[breath.hold]
creep_mm = 5.6
creep_s = 20.0
missed = 0.2
level = 0.1
limit_s = 15.0
[start]
deeper_mm = -50.0
[hand]
ramp_s = 0.4
tremor_mm = 0.1
tremor_low_hz = 8.0
tremor_high_hz = 10.0
[[stage]]
do = "hold"
seconds = 0.5
[[stage]]
do = "move"
share = 1.0
deeper_mm = 1.0
speed_mm_s = 13.0
[[stage]]
do = "take"
tool = "probe"
seconds = 0.8
[[stage]]
do = "move"
share = 0.0
headward_mm = 5.0
frontward_mm = -3.0
headward_deg = 10.0
frontward_deg = -5.0
roll_deg = -35.0
speed_mm_s = 20.0
[[stage]]
do = "park"
[[stage]]
do = "lift"
[[stage]]
do = "aspirate"
[[stage]]
do = "inject"
ml_per_s = 1.5
seconds = 4.0
[[stage]]
do = "pedal"
down = true
[[stage]]
do = "xray"
field_mm = 200.0
rotation_deg = -30.0
[[stage]]
do = "ultrasound"
depth_mm = 120.0
[[stage]]
do = "move"
capsule_share = 0.5
deeper_mm = -3.0
speed_mm_s = 20.0
[[stage]]
do = "numb"
ml_per_s = 0.5
seconds = 2.0
)";

class ScenarioFile : public testing::Test {
  protected:
    Scenario load(const std::string& text) const {
        std::ofstream(file_, std::ios::trunc) << text;
        return loadScenario(file_);
    }
    // Replaces `from` with `to` in the valid file. Expects that the file is rejected because of `field`.
    void expectRefused(const std::string& from, const std::string& to, const std::string& field) const {
        std::string text = kGood;
        text.replace(text.find(from), from.size(), to);
        try {
            (void)load(text);
            FAIL() << to << " was not refused";
        } catch (const DataError& e) {
            EXPECT_EQ(std::string(e.what()).rfind(file_.string() + ": " + field + ": ", 0), 0u) << e.what();
        }
    }

    test::TempFolder folder_;
    std::filesystem::path file_ = folder_ / "scenario.toml";
};

TEST_F(ScenarioFile, NamesItsCaseOrDrawsOneByTheSeed) {
    const std::string course = "course = \"drainage\"\n";
    std::string named = kGood;
    named.replace(named.find(course), course.size(), course + "case = \"ascites\"\n");
    Scenario s = load(named);
    ASSERT_TRUE(s.patient_case);
    EXPECT_EQ(s.patient_case->ascites, training::Ascites::large);
    const auto kept = s.patient_case;
    drawCase(s, 5);
    EXPECT_EQ(s.patient_case, kept);

    std::set<std::string> drawn;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        Scenario one = load(kGood), again = load(kGood);
        const std::uint64_t without = digest(one);
        drawCase(one, seed), drawCase(again, seed);
        ASSERT_TRUE(one.patient_case);
        EXPECT_EQ(one.patient_case->toml, again.patient_case->toml);
        EXPECT_EQ(digest(one), digest(again));
        EXPECT_NE(digest(one), without);
        drawn.insert(one.patient_case->title);
    }
    EXPECT_GE(drawn.size(), 9u) << "of ten cases";

    expectRefused(course, "case = \"clean\"\n", "case");
    expectRefused(course, course + "case = \"\"\n", "case");
    named.replace(named.find("ascites"), 7, "asccites");
    EXPECT_THROW((void)load(named), DataError);
    std::string puncture = kGood;
    puncture.erase(puncture.find(course), course.size());
    Scenario without = load(puncture);
    drawCase(without, 5);
    EXPECT_FALSE(without.patient_case);
}

TEST_F(ScenarioFile, ReadsEveryFieldInMetres) {
    const Scenario s = load(kGood);
    EXPECT_EQ(s.name, "good");
    EXPECT_EQ(s.moments, (std::vector<std::string>{"approach", "duct"}));
    EXPECT_DOUBLE_EQ(s.approach_distance_m, 0.020);
    EXPECT_DOUBLE_EQ(s.start.deeper_m, -0.050);
    EXPECT_DOUBLE_EQ(s.tremor_m, 0.0001);
    EXPECT_EQ(s.breath.period_s, 5.0);
    EXPECT_FALSE(s.breath.amplitude);
    EXPECT_EQ(s.breath.plan.period_jitter, 0.1);
    EXPECT_EQ(s.breath.plan.depth_jitter, 0.12);
    EXPECT_EQ(s.breath.plan.sighs, 0.02);
    EXPECT_EQ(s.breath.plan.coughs, 0.01);
    EXPECT_DOUBLE_EQ(s.breath.creep_m, 0.0056);
    EXPECT_EQ(s.breath.plan.hold, (patient::HoldBehaviour{0.0, 20.0, 0.2, 0.1, 15.0}));
    EXPECT_EQ(s.tool, haptics::Tool::finger);
    EXPECT_EQ(s.course, training::Course::drainage);
    ASSERT_EQ(s.stages.size(), 13u);
    EXPECT_EQ(s.stages[0].kind, StageKind::hold);
    EXPECT_EQ(s.stages[1].kind, StageKind::move);
    EXPECT_DOUBLE_EQ(s.stages[1].to.share, 1.0);
    EXPECT_DOUBLE_EQ(s.stages[1].to.deeper_m, 0.001);
    EXPECT_DOUBLE_EQ(s.stages[1].speed_m_s, 0.013);
    EXPECT_EQ(s.stages[2].kind, StageKind::changeTool);
    EXPECT_EQ(s.stages[2].tool, haptics::Tool::probe);
    EXPECT_DOUBLE_EQ(s.stages[2].seconds, 0.8);
    EXPECT_DOUBLE_EQ(s.stages[3].to.headward_m, 0.005);
    EXPECT_DOUBLE_EQ(s.stages[3].to.frontward_m, -0.003);
    EXPECT_NEAR(s.stages[3].to.headward_rad, 0.174533, 1e-6);
    EXPECT_NEAR(s.stages[3].to.frontward_rad, -0.087266, 1e-6);
    EXPECT_NEAR(s.stages[3].to.roll_rad, -0.610865, 1e-6);
    EXPECT_EQ(s.stages[4].kind, StageKind::park);
    EXPECT_EQ(s.stages[5].kind, StageKind::lift);
    EXPECT_EQ(s.stages[6].kind, StageKind::aspirate);
    EXPECT_EQ(s.stages[7].kind, StageKind::inject);
    EXPECT_DOUBLE_EQ(s.stages[7].injected_m3_per_s, 1.5e-6);
    EXPECT_DOUBLE_EQ(s.stages[7].seconds, 4.0);
    EXPECT_EQ(s.stages[8].kind, StageKind::pedal);
    EXPECT_TRUE(s.stages[8].pedal_down);
    EXPECT_EQ(s.stages[9].kind, StageKind::machine);
    using training::Machine;
    EXPECT_EQ(s.stages[9].turned, (std::vector<training::KnobSetting>{
                                      {Machine::xray, std::size_t(training::XrayKnob::rotation), -30.0},
                                      {Machine::xray, std::size_t(training::XrayKnob::field), 200.0}}));
    EXPECT_EQ(s.stages[10].turned,
              (std::vector<training::KnobSetting>{
                  {Machine::ultrasound, std::size_t(training::UltrasoundKnob::depth), 120.0}}));
    EXPECT_TRUE(s.stages[11].to.to_capsule);
    EXPECT_DOUBLE_EQ(s.stages[11].to.share, 0.5);
    EXPECT_EQ(s.stages[12].kind, StageKind::numb);
    EXPECT_DOUBLE_EQ(s.stages[12].injected_m3_per_s, 0.5e-6);
}

TEST_F(ScenarioFile, RefusesBadFilesByFieldAndReason) {
    expectRefused("name = \"good\"", "name = 3", "name");
    expectRefused("name = \"good\"", "name = \"good", "line 2");
    expectRefused("\"duct\"]", "\"spleen\"]", "moments");
    expectRefused("\"duct\"]", "\"approach\"]", "moments");
    expectRefused("approach_distance_mm = 20.0", "", "approach_distance_mm");
    expectRefused("approach_distance_mm = 20.0", "approach_distance_mm = nan", "approach_distance_mm");
    expectRefused("[start]\ndeeper_mm = -50.0", "", "start");
    expectRefused("deeper_mm = -50.0", "deeper_mm = -5000.0", "start.deeper_mm");
    expectRefused("deeper_mm = -50.0", "deeper_mm = -50.0\nx_mm = 3.0", "start.x_mm");
    expectRefused("period_s = 5.0", "period_s = 0.1", "breath.period_s");
    expectRefused("period_s = 5.0", "recording = \"track.csv\"", "breath.period_jitter");
    expectRefused("sighs = 0.02", "sighs = 2", "breath.sighs");
    expectRefused("coughs = 0.01", "cough = 0.01", "breath.cough");
    expectRefused("creep_mm = 5.6", "creep_mm = -5.6", "breath.hold.creep_mm");
    expectRefused("creep_s = 20.0", "creep_s = 0", "breath.hold.creep_s");
    expectRefused("missed = 0.2", "missed = 1.0", "breath.hold.missed");
    expectRefused("limit_s = 15.0", "limit_s = nan", "breath.hold.limit_s");
    expectRefused("tremor_high_hz = 10.0", "tremor_high_hz = 7.0", "hand.tremor_high_hz");
    expectRefused("ramp_s = 0.4", "ramp_s = 0.0", "hand.ramp_s");
    expectRefused("do = \"hold\"", "do = \"jump\"", "stage[0].do");
    expectRefused("seconds = 0.5", "seconds = -0.5", "stage[0].seconds");
    expectRefused("speed_mm_s = 13.0", "", "stage[1].speed_mm_s");
    expectRefused("speed_mm_s = 13.0", "speed_mm_s = inf", "stage[1].speed_mm_s");
    expectRefused("share = 1.0\ndeeper_mm = 1.0", "", "stage[1].share");
    expectRefused("capsule_share = 0.5", "capsule_share = 1.5", "stage[11].capsule_share");
    expectRefused("capsule_share = 0.5", "capsule_share = 0.5\nshare = 0.5", "stage[11].capsule_share");
    expectRefused("ml_per_s = 0.5", "ml_per_s = 3.0", "stage[12].ml_per_s");
    expectRefused("tool = \"finger\"", "tool = \"spoon\"", "tool");
    expectRefused("tool = \"probe\"", "tool = 3", "stage[2].tool");
    expectRefused("tool = \"probe\"", "", "stage[2].tool");
    expectRefused("seconds = 0.8", "seconds = 0.0", "stage[2].seconds");
    expectRefused("headward_mm = 5.0", "headward_mm = 5000.0", "stage[3].headward_mm");
    expectRefused("headward_deg = 10.0", "headward_deg = 90.0", "stage[3].headward_deg");
    expectRefused("roll_deg = -35.0", "roll_deg = nan", "stage[3].roll_deg");
    expectRefused("do = \"park\"", "do = \"park\"\nseconds = 1.0", "stage[4].seconds");
    expectRefused("share = 1.0", "shore = 1.0", "stage[1].shore");
    expectRefused("ml_per_s = 1.5", "", "stage[7].ml_per_s");
    expectRefused("ml_per_s = 1.5", "ml_per_s = 21.0", "stage[7].ml_per_s");
    expectRefused("ml_per_s = 1.5", "ml_per_s = -1.0", "stage[7].ml_per_s");
    expectRefused("ml_per_s = 1.5", "ml_per_s = nan", "stage[7].ml_per_s");
    expectRefused("seconds = 4.0", "seconds = 4000.0", "stage[7].seconds");
    expectRefused("seconds = 4.0", "second = 4.0", "stage[7].second");
    expectRefused("down = true", "", "stage[8].down");
    expectRefused("down = true", "down = 1", "stage[8].down");
    expectRefused("field_mm = 200.0", "field_mm = 2000.0", "stage[9].field_mm");
    expectRefused("field_mm = 200.0", "depth_mm = 200.0", "stage[9].depth_mm");
    expectRefused("rotation_deg = -30.0", "rotation_deg = \"left\"", "stage[9].rotation_deg");
    expectRefused("depth_mm = 120.0", "", "stage[10].do");
}

TEST_F(ScenarioFile, RefusesAFileThatIsNotThere) {
    EXPECT_THROW((void)loadScenario(folder_ / "none.toml"), DataError);
}

TEST_F(ScenarioFile, DigestCoversContentNotLayout) {
    const std::uint64_t first = digest(load(kGood));
    EXPECT_EQ(digest(load(std::string("# a comment\n") + kGood)), first);
    std::string faster = kGood;
    faster.replace(faster.find("13.0"), 4, "13.5");
    EXPECT_NE(digest(load(faster)), first);
    std::string aside = kGood;
    aside.replace(aside.find("headward_mm = 5.0"), 17, "headward_mm = 5.5");
    EXPECT_NE(digest(load(aside)), first);
    std::string rolled = kGood;
    rolled.replace(rolled.find("roll_deg = -35.0"), 16, "roll_deg = -34.0");
    EXPECT_NE(digest(load(rolled)), first);
    std::string other = kGood;
    other.replace(other.find("\"probe\""), 7, "\"guide\"");
    EXPECT_NE(digest(load(other)), first);
    for (const auto& [from, to] : {std::pair<std::string, std::string>{"ml_per_s = 1.5", "ml_per_s = 1.6"},
                                   {"down = true", "down = false"},
                                   {"field_mm = 200.0", "field_mm = 201.0"},
                                   {"depth_mm = 120.0", "focus_mm = 120.0"}}) {
        std::string turned = kGood;
        turned.replace(turned.find(from), from.size(), to);
        EXPECT_NE(digest(load(turned)), first) << to;
    }
}

TEST_F(ScenarioFile, NamesItsNeedle) {
    const std::string text = kGood;
    EXPECT_EQ(load(text).needle, "");
    const Scenario s = load("needle = \"chiba-22g\"\n" + text);
    EXPECT_EQ(s.needle, "chiba-22g");
    EXPECT_NE(digest(s), digest(load(text)));
    EXPECT_NE(digest(s), digest(load("needle = \"chiba-21g\"\n" + text)));
    for (const char* bad : {"needle = \"\"\n", "needle = 22\n", "needle = [\"chiba-22g\"]\n"})
        EXPECT_NE(test::errorText([&] { load(bad + text); }).find("needle"), std::string::npos) << bad;
}

TEST_F(ScenarioFile, NamesItsInstruments) {
    const std::string text = kGood;
    EXPECT_TRUE(load(text).instruments.empty());
    const Scenario s = load("instruments = [\"probe-linear\", \"my/scalpel.toml\"]\n" + text);
    EXPECT_EQ(s.instruments, (std::vector<std::string>{"probe-linear", "my/scalpel.toml"}));
    EXPECT_NE(digest(s), digest(load(text)));
    EXPECT_NE(digest(s), digest(load("instruments = [\"probe-linear\"]\n" + text)));
    std::string many = "instruments = [\"a\"";
    for (int i = 0; i < 20; ++i)
        many += ", \"a\"";
    for (const std::string& bad :
         {std::string("instruments = \"probe-linear\"\n"), std::string("instruments = [1]\n"),
          std::string("instruments = [\"finger\", \"\"]\n"), many + "]\n"})
        EXPECT_NE(test::errorText([&] { load(bad + text); }).find("instruments"), std::string::npos) << bad;
}

TEST_F(ScenarioFile, BringsItsRecordingAlong) {
    std::string text = kGood;
    const std::size_t from = text.find("period_s"), to = text.find("[start]");
    text.replace(from, to - from, "recording = \"track.csv\"\n");
    EXPECT_THROW((void)load(text), DataError);  // the file does not exist yet
    std::ofstream track(folder_ / "track.csv");
    track << "Frame;Timestamp;x;y;z\n";
    for (int i = 0; i < 400; ++i)
        track << i << ';' << i * 100 << ";1;0;" << 10.0 - 10.0 * std::cos(0.1 * i) << '\n';
    track.close();
    const Scenario s = load(text);
    EXPECT_GT(s.breath.plan.recording_v.size(), 300u);
    std::string other = text;
    other.replace(other.find("[start]"), 0, "amplitude = 0.9\n");
    EXPECT_NE(digest(load(other)), digest(s));
}

TEST(ShippedScenarios, LoadAndDifferOnlyInTheHold) {
    const std::filesystem::path folder = test::assets() / "scenarios";
    const Scenario demo = loadScenario(folder / "demo.toml"),
                   free = loadScenario(folder / "demo-breathing.toml");
    const auto commands = [](const Scenario& s) {
        int count = 0;
        for (const Stage& stage : s.stages)
            count += stage.kind == StageKind::hold || stage.kind == StageKind::breathe;
        return count;
    };
    const auto moves = [](const Scenario& s) {
        std::vector<Stage> list;
        for (const Stage& stage : s.stages)
            if (stage.kind == StageKind::move) list.push_back(stage);
        return list;
    };
    EXPECT_EQ(commands(demo), 2);
    EXPECT_EQ(commands(free), 0);
    EXPECT_EQ(moves(demo), moves(free));
}

}  // namespace
}  // namespace stylet::trainer
