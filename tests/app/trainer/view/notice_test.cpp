#include "app/trainer/view/notice.h"

#include <cmath>
#include <filesystem>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/trainer/assets.h"

namespace stylet::trainer {
namespace {

using testing::HasSubstr;

// Checks the size of the notice text and of its panel in several headsets. One em of the font must span at
// least 0.4 degrees and 20 pixels. The panel must be less than 50 degrees wide, so that it does not fill the
// view.
TEST(Notice, CanBeReadInEveryHeadset) {
    struct Headset {
        const char* name;
        double width_px, left_deg, right_deg;
    };
    for (const Headset& h :
         {Headset{"Valve Index", 2468, -51.98, 51.53}, Headset{"Meta Quest 3", 2064, -54, 44},
          Headset{"narrow and coarse, as the demo's", 640, -35.5, 28.6},
          Headset{"as fine as the eye", 6000, -45, 45}}) {
        SCOPED_TRACE(h.name);
        const double degree = std::numbers::pi / 180.0;
        const double px_per_rad =
            h.width_px / (std::tan(h.right_deg * degree) - std::tan(h.left_deg * degree));
        const double letter = letterAngle_rad(px_per_rad);
        EXPECT_GE(letter, 0.4 * degree * (1.0 - 1e-12));
        EXPECT_GE(letter * px_per_rad, 20.0 * (1.0 - 1e-12));
        const double width_m = NoticePanel::width_m(1.0, letter);
        EXPECT_NEAR(width_m * NoticePanel::kLetter_px / NoticePanel::kWidth, std::tan(letter), 1e-12);
        EXPECT_LT(2.0 * std::atan(0.5 * width_m), 50.0 * degree);
    }
}

TEST(Notice, ExplainsWhyTheAttemptIsPaused) {
    FrameState seen;
    seen.tick.stage = haptics::ForceStage::on;
    EXPECT_FALSE(makeNotice(seen, Attention::focused, "press Enter"));
    EXPECT_FALSE(makeNotice(seen, Attention::absent, "press Enter"));
    EXPECT_EQ(makeNotice(seen, Attention::away, "")->title, "Paused");
    seen.ticks_paused = true, seen.return_distance_m = 0.0123;
    EXPECT_THAT(makeNotice(seen, Attention::focused, "")->lines[0], HasSubstr("12 mm"));
    seen.return_distance_m = haptics::kDeviceNotReady_m;
    EXPECT_THAT(makeNotice(seen, Attention::focused, "")->lines[0], HasSubstr("not tracked"));
    seen.ticks_paused = false;
    seen.tick.stage = haptics::ForceStage::off;
    seen.tick.faults = haptics::kFaultOverSpeed;
    EXPECT_FALSE(makeNotice(seen, Attention::focused, "")) << "a script cannot re-arm";
    const Notice fault = *makeNotice(seen, Attention::focused, "press Enter");
    EXPECT_THAT(fault.lines[0], HasSubstr("1 m/s"));
    EXPECT_THAT(fault.lines[1], HasSubstr("press Enter"));
    seen.tick.awaited = haptics::kFaultAwayFromNeedle;
    EXPECT_THAT(makeNotice(seen, Attention::focused, "")->lines[0], HasSubstr("move the tool back"));
    EXPECT_THAT(makeNotice(RoomWarning::lost, "press Enter").lines[1], HasSubstr("stylet register"));
    EXPECT_THAT(makeNotice(RoomWarning::moved, "press Enter").lines[0], HasSubstr("press Enter"));
}

// After a leap, or when a tool is taken inside the body, a missing force must not look like a fault.
TEST(Notice, AsksToLiftAToolThatFeelsNothing) {
    FrameState seen;
    seen.tick.tick = 1;
    seen.tick.stage = haptics::ForceStage::on;
    seen.tick.tool_awaits_exit = true;
    EXPECT_THAT(makeNotice(seen, Attention::focused, "")->lines[0], HasSubstr("lift it"));
    seen.tick.stage = haptics::ForceStage::off;
    seen.tick.faults = haptics::kFaultOverSpeed;
    EXPECT_EQ(makeNotice(seen, Attention::focused, "press Enter")->title, "The force is off");
    seen.tick.tool_awaits_exit = false;
    EXPECT_FALSE(makeNotice(seen, Attention::focused, ""));
}

TEST(Notice, AStalledPictureIsCalledSo) {
    FrameState seen;
    seen.picture_stall_s = 4.2;
    const auto mouse = makeNotice(seen, Attention::focused, "");
    ASSERT_TRUE(mouse);
    EXPECT_EQ(mouse->lines,
              std::vector<std::string>{"The picture had stopped for 4 s; the attempt continued."});
    seen.tick.stage = haptics::ForceStage::off;
    seen.tick.faults = haptics::kFaultNotFocused;
    const auto haptic = makeNotice(seen, Attention::focused, "Enter");
    ASSERT_TRUE(haptic);
    EXPECT_EQ(haptic->lines,
              (std::vector<std::string>{"The picture had stopped for 4 s.", "To resume: Enter."}));
    seen.tick.faults = haptics::kFaultOverSpeed;
    EXPECT_THAT(makeNotice(seen, Attention::focused, "Enter")->lines[0], HasSubstr("1 m/s"));
}

TEST(Notice, SaysWhatTheSyringeDrew) {
    FrameState seen;
    seen.drawn = training::Drawn::blood;
    const auto notice = makeNotice(seen, Attention::focused, "");
    ASSERT_TRUE(notice);
    EXPECT_EQ(*notice, (Notice{"Syringe", {"Blood comes."}}));
    seen.paused_by_instructor = true;
    EXPECT_EQ(makeNotice(seen, Attention::focused, "")->title, "Paused") << "that is more important";
}

// As on a real syringe, in an exam too, and nothing but that: not where it went.
TEST(Notice, ShowsTheSyringesScale) {
    FrameState seen;
    seen.difficulty = training::Difficulty::exam;
    seen.syringe = {true, 1.54e-6};
    const Notice notice{"Syringe", {"Local anaesthetic: 1.5 ml injected."}};
    EXPECT_EQ(makeNotice(seen, Attention::focused, ""), notice);
    seen.progress.track_place = training::TrackPlace::aside;
    seen.progress.refusal = training::Refusal::anaestheticAside;
    seen.tick.tissue = patient::Tissue::vessel;
    EXPECT_EQ(makeNotice(seen, Attention::focused, ""), notice);
    seen.syringe = {false, 12.0e-6};
    seen.drawn = training::Drawn::bile;
    EXPECT_EQ(makeNotice(seen, Attention::focused, ""),
              (Notice{"Syringe", {"Bile comes.", "Contrast medium: 12.0 ml injected."}}));
}

TEST(Notice, SaysWhyTheNextAttemptWasRefused) {
    FrameState seen;
    seen.start_refused = "it senses no rotation. This attempt has the settings of the last one: practice.";
    const auto notice = makeNotice(seen, Attention::focused, "");
    ASSERT_TRUE(notice);
    EXPECT_EQ(notice->lines, std::vector<std::string>{seen.start_refused});
    seen.tick.stage = haptics::ForceStage::off;
    EXPECT_THAT(makeNotice(seen, Attention::focused, "Enter")->lines.back(), HasSubstr("no rotation"))
        << "the force has not started yet";
    // Nothing that must be acted on is hidden.
    seen.paused_by_instructor = true;
    EXPECT_EQ(makeNotice(seen, Attention::focused, "")->title, "Paused");
    seen.paused_by_instructor = false, seen.tick.awaited = haptics::kFaultAwayFromNeedle;
    EXPECT_EQ(makeNotice(seen, Attention::focused, "")->title, "The tool has jumped");
}

TEST(Notice, SaysWhatTheExpertCannotShow) {
    FrameState seen;
    seen.expert_note = "the expert cannot show it: there is no path";
    EXPECT_EQ(makeNotice(seen, Attention::focused, ""),
              (Notice{"Expert", {"The expert cannot show it: there is no path."}}));
    seen.tick.stage = haptics::ForceStage::off;
    seen.tick.faults = haptics::kFaultOverSpeed;
    EXPECT_EQ(makeNotice(seen, Attention::focused, "Enter")->title, "The force is off")
        << "that is more important";
}

// A frame in which the case's questions are asked.
FrameState asking(const std::string& name, int answered) {
    FrameState seen;
    seen.patient_case = std::make_shared<const training::PatientCase>(
        training::loadCase(test::assets() / "cases" / (name + ".toml")));
    seen.progress.course = training::Course::drainage;
    seen.progress.has_case = true;
    seen.progress.step = training::Step::reviewCase;
    seen.progress.answered = std::uint8_t(answered);
    return seen;
}

// In an exam too: the case, the question and the keys, but nothing about earlier answers.
TEST(Notice, ShowsTheCaseWithItsQuestionAndKeys) {
    FrameState seen = asking("raised-inr", 2);
    const Notice notice = *makeNotice(seen, Attention::focused, "", training::kMouseControls);
    EXPECT_EQ(notice.title, "The case, question 3 of 7");
    std::string text;
    for (const std::string& line : notice.lines)
        text += line + "\n";
    EXPECT_THAT(text, HasSubstr("INR 2.4"));
    EXPECT_THAT(text, HasSubstr(std::string(questionText(training::Question::ascites))));
    EXPECT_THAT(text, HasSubstr("Yes: press Y. No: press U."));
    FrameState other = seen;
    other.progress.yes = 3;
    EXPECT_EQ(*makeNotice(other, Attention::focused, "", training::kMouseControls), notice);
    seen.progress.step = training::Step::findGap;
    EXPECT_FALSE(makeNotice(seen, Attention::focused, ""));
    seen = asking("raised-inr", 0);
    seen.paused_by_instructor = true;
    EXPECT_EQ(makeNotice(seen, Attention::focused, "")->title, "Paused") << "that is more important";
}

TEST(Notice, EveryCaseFitsItsPanel) {
    NoticePanel panel;
    for (const auto& entry : std::filesystem::directory_iterator(test::assets() / "cases")) {
        if (entry.path().extension() != ".toml") continue;
        for (int question = 0; question < training::kQuestionCount; ++question) {
            panel.show(*makeNotice(asking(entry.path().stem(), question), Attention::focused, "",
                                   training::kControllerControls));
            ASSERT_EQ(panel.height(), NoticePanel::kTallHeight);
            ASSERT_EQ(panel.rgba().size(), std::size_t(4 * NoticePanel::kWidth * NoticePanel::kTallHeight));
            for (std::size_t y = NoticePanel::kTallHeight - 12; y < NoticePanel::kTallHeight; ++y)
                for (std::size_t x = 0; x < NoticePanel::kWidth; ++x)
                    ASSERT_LT(panel.rgba()[4 * (y * NoticePanel::kWidth + x)], 60) << entry.path();
        }
    }
    panel.show(makeNotice(RoomWarning::lost, ""));
    EXPECT_EQ(panel.height(), NoticePanel::kHeight);
    EXPECT_EQ(panel.rgba().size(), std::size_t(4 * NoticePanel::kWidth * NoticePanel::kHeight));
}

// No text is drawn outside the margins, and none below the rows that are said to be filled.
void expectMargins(const NoticePanel& panel, const std::string& what) {
    const auto width = std::size_t(NoticePanel::kWidth), height = std::size_t(panel.height());
    ASSERT_LE(panel.filledHeight(), panel.height()) << what;
    for (std::size_t y = 12; y < height; ++y)
        for (std::size_t x = 0; x < width; ++x)
            if (x < 20 || x >= width - 20 || y >= std::size_t(panel.filledHeight()) - 8) {
                ASSERT_LT(panel.rgba()[4 * (y * width + x)], 60) << what << " at " << x << ", " << y;
            }
}

// A case as long as its loader admits: in every value the longest, and in the free texts of letters of
// different widths.
FrameState askingLongest(const std::string& word, bool admitted = true) {
    std::string text;
    while (text.size() < 200)
        text += word;
    const auto field = [&](const char* name, std::size_t bytes) {
        return std::string(name) + " = \"" + text.substr(0, bytes + (admitted ? 0 : 1)) + "\"\n";
    };
    FrameState seen;
    seen.patient_case = std::make_shared<const training::PatientCase>(training::parseCase(
        field("title", 70) + field("finding", 70) + field("other_allergies", 40) +
            "age_years = 120\nsex = \"female\"\nurgency = \"emergency\"\ntemperature_c = 42.95\n"
            "liver_disease = false\nascites = \"small\"\ncontrast_reaction = \"severe\"\n"
            "blood_thinner = \"clopidogrel\"\nlast_dose_h = 999.123\nantibiotic_min = 9999.12\n"
            "consent = \"presumed\"\n[blood]\ninr = 14.1234\nplatelets_e9_per_l = 1234.12\n"
            "bilirubin_umol_per_l = 999.123\ncrp_mg_per_l = 999.123\negfr_ml_per_min = 149.123\n",
        "long.toml"));
    seen.progress.course = training::Course::drainage;
    seen.progress.has_case = true;
    seen.progress.step = training::Step::reviewCase;
    return seen;
}

TEST(Notice, ACaseAtItsLimitsFitsItsPanel) {
    NoticePanel panel;
    for (const std::string word : {"obstructed duct ", "WW", "W", "i", "ä"})
        for (int question = 0; question < training::kQuestionCount; ++question) {
            FrameState seen = askingLongest(word);
            seen.progress.answered = std::uint8_t(question);
            panel.show(*makeNotice(seen, Attention::focused, "", training::kControllerControls));
            expectMargins(panel, word);
            const bool usual = word.ends_with(' ');
            EXPECT_TRUE(!usual || panel.letter_px() == NoticePanel::kLetter_px) << panel.letter_px();
            EXPECT_GT(panel.letter_px(), NoticePanel::kSmallest_px) << word;
        }
    EXPECT_THAT([] { askingLongest("W", false); },
                testing::ThrowsMessage<DataError>(HasSubstr("long.toml: title: ")));
}

// Nothing of a longer text is lost: it has smaller letters.
TEST(Notice, LongTextShrinks) {
    NoticePanel panel;
    panel.show({"A request was refused", {std::string(1200, 'e')}, true});
    EXPECT_LT(panel.letter_px(), NoticePanel::kLetter_px);
    expectMargins(panel, "1200 letters");
    report::Canvas canvas(100, 100, {});
    const report::TextStyle style{.size = 20.0, .colour = {1.0, 1.0, 1.0}};
    std::string joined;
    for (const std::string& line : wrapped(canvas, "aäöü" + std::string(50, 'W'), style, 60.0)) {
        EXPECT_LE(canvas.textWidth(line, style), 60.0) << line;
        joined += line;
    }
    EXPECT_EQ(joined, "aäöü" + std::string(50, 'W'));
}

// The longest notices fit the panel: no bright pixels touch its lower edge.
TEST(Notice, FitsItsPanel) {
    NoticePanel panel;
    for (const haptics::FaultText& fault : haptics::faultTexts()) {
        FrameState seen;
        seen.tick.stage = haptics::ForceStage::off;
        seen.tick.faults = fault.bit;
        const auto notice = makeNotice(seen, Attention::focused, "the device's first button, or Enter here,");
        if (fault.bit == haptics::kFaultRingFull) continue;
        panel.show(*notice);
        expectMargins(panel, fault.name);
    }
    panel.show({"Syringe", {"Bile comes."}});
    EXPECT_LT(panel.filledHeight(), 0.6 * NoticePanel::kHeight) << "a short notice hides little";
    for (int y = 0; y < panel.height(); ++y)
        EXPECT_EQ(panel.rgba()[4 * std::size_t(y * NoticePanel::kWidth) + 3],
                  y < panel.filledHeight() ? 255 : 0)
            << y;
    const std::uint64_t revision = panel.revision();
    panel.show(makeNotice(RoomWarning::lost, ""));
    EXPECT_EQ(panel.revision(), revision + 1);
    panel.show(makeNotice(RoomWarning::lost, ""));
    EXPECT_EQ(panel.revision(), revision + 1) << "drawn only when it is another one";
}

}  // namespace
}  // namespace stylet::trainer
