#include "app/trainer/session/instructor.h"

#include <gtest/gtest.h>

namespace stylet::trainer {
namespace {

using haptics::CommandKind;

TEST(Instructor, ReturnsLinesThatAreNotInstructorCommands) {
    Instructor instructor;
    EXPECT_EQ(instructor.processLines("probe\ncough\nne"), "probe\n");
    EXPECT_EQ(instructor.processLines("xt\nlights out\r\nlights\ncoughs\n"), "next\nlights\ncoughs\n");
    const std::vector<haptics::Command> commands = instructor.popCommands();
    ASSERT_EQ(commands.size(), 2u);
    EXPECT_EQ(commands[0].kind, CommandKind::cough);
    EXPECT_EQ(commands[1].kind, CommandKind::lights);
    EXPECT_EQ(commands[1].value, 0u);
    EXPECT_EQ(injectedName(commands[1]), "lights out");
    EXPECT_TRUE(instructor.popCommands().empty());
}

TEST(Instructor, ReportsEachPauseAndNoteOnce) {
    Instructor instructor;
    EXPECT_EQ(instructor.processLines("pause\npause\n"), "");
    EXPECT_TRUE(instructor.paused());
    EXPECT_EQ(instructor.processLines("go on\nbookmark\ncomment  too steep \nbookmarks\n"), "bookmarks\n");
    EXPECT_FALSE(instructor.paused());
    const std::vector<Instructor::Note> notes = instructor.popNotes();
    ASSERT_EQ(notes.size(), 4u);
    EXPECT_EQ(notes[0].text, "paused");
    EXPECT_EQ(notes[1].text, "goes on");
    EXPECT_EQ(notes[2].kind, "bookmark");
    EXPECT_EQ(notes[2].text, "");
    EXPECT_EQ(notes[3].kind, "comment");
    EXPECT_EQ(notes[3].text, "too steep");
}

TEST(Instructor, ScalesTheBreathByOneNumberOrTwo) {
    Instructor instructor;
    EXPECT_EQ(instructor.processLines("breathing 1.3\nbreathing  0.7  1.9 \n"), "");
    const std::vector<haptics::Command> commands = instructor.popCommands();
    ASSERT_EQ(commands.size(), 2u);
    EXPECT_EQ(haptics::breathingScale(commands[0]), (haptics::BreathingScale{1.3, 1.0}));
    EXPECT_EQ(haptics::breathingScale(commands[1]), (haptics::BreathingScale{0.7, 1.9}));
    EXPECT_EQ(injectedName(commands[1]), "breathing 0.7 1.9");
    EXPECT_EQ(instructor.processLines(
                  "breathing\nbreathing 3\nbreathing 1 x\nbreathing 1 1 1\nbreathing nan\nbreathe\n"),
              "breathe\n");
    EXPECT_TRUE(instructor.popCommands().empty());
    EXPECT_EQ(instructor.popAnswers().size(), 5u);
    EXPECT_TRUE(instructor.popAnswers().empty());
}

// HZ-TEACH-12
TEST(Instructor, SetsTheDifficultyAtOnce) {
    Instructor instructor;
    EXPECT_EQ(instructor.processLines("difficulty exam\n"), "");
    EXPECT_EQ(instructor.popDifficulty(), training::Difficulty::exam);
    EXPECT_FALSE(instructor.popDifficulty());
    ASSERT_EQ(instructor.popNotes().size(), 1u);
    EXPECT_EQ(instructor.processLines("difficulty\ndifficulty hard\n"), "");
    EXPECT_FALSE(instructor.popDifficulty());
    EXPECT_EQ(instructor.popAnswers().size(), 2u);
}

TEST(Instructor, AbortsTheAttempt) {
    Instructor instructor;
    EXPECT_EQ(instructor.processLines("abort it\n"), "abort it\n");
    EXPECT_FALSE(instructor.aborted());
    EXPECT_EQ(instructor.processLines("abort\n"), "");
    EXPECT_TRUE(instructor.aborted());
    EXPECT_FALSE(instructor.next());
}

TEST(Instructor, CollectsSettingsOfTheNextAttempt) {
    Instructor instructor;
    EXPECT_EQ(instructor.processLines(
                  "new patient /patients/a b\nnew scenario procedure\nnew difficulty guided\nnext\n"),
              "next\n")
        << "next is the trainee's: the next tool";
    EXPECT_FALSE(instructor.next());
    instructor.processLines("new attempt\n");
    ASSERT_TRUE(instructor.next());
    EXPECT_EQ(instructor.next()->patient, "/patients/a b");
    EXPECT_EQ(instructor.next()->scenario, "procedure");
    EXPECT_EQ(instructor.next()->difficulty, training::Difficulty::guided);
    EXPECT_FALSE(instructor.next()->seed);
    EXPECT_FALSE(instructor.next()->from_bookmark);
}

TEST(Instructor, SeedReplacesThePatientAndInvalidInputIsRefused) {
    Instructor instructor;
    instructor.processLines(
        "new patient /a\nnew seed 7\nnew\nnew seed x\nnew seed\nnew difficulty\nnew tool\n");
    const std::vector<std::string> answers = instructor.popAnswers();
    ASSERT_EQ(answers.size(), 7u);
    EXPECT_EQ(answers[0], "the next attempt has patient /a");
    EXPECT_EQ(answers[1], "the next attempt has seed 7");
    instructor.processLines("new attempt\n");
    EXPECT_EQ(instructor.next()->seed, 7u);
    EXPECT_FALSE(instructor.next()->patient);
    Instructor again;
    again.processLines("retry\n");
    ASSERT_TRUE(again.next());
    EXPECT_TRUE(again.next()->from_bookmark);
}

TEST(Instructor, LongIncompleteLineIsReturned) {
    Instructor instructor;
    const std::string much(4000, 'x');
    EXPECT_EQ(instructor.processLines(much), much);
}

TEST(Instructor, EveryInjectedEventHasAName) {
    for (const CommandKind kind :
         {CommandKind::cough, CommandKind::sigh, CommandKind::move, CommandKind::fault, CommandKind::bleed,
          CommandKind::lights, CommandKind::breathing})
        EXPECT_FALSE(injectedName({kind, 0}).empty());
    EXPECT_TRUE(injectedName({CommandKind::tool, 0}).empty());
}

}  // namespace
}  // namespace stylet::trainer
