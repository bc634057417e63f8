#include "tests/app/trainer/attempt/novice_inputs.h"

#include <cctype>
#include <utility>

#include "app/trainer/hands/controller_hand.h"
#include "app/trainer/hands/live_hand.h"
#include "app/trainer/hands/mouse_hand.h"
#if defined(STYLET_WINDOW)
#include "app/trainer/window/window_keys.h"
#endif

namespace stylet::test {

namespace {

// `kPatient_s`: most of these inputs are switches, which a second press would turn back.
constexpr double kImpatient_s = 0.5, kPatient_s = 10.0;

class TypedInput final : public NoviceInput {
  public:
    TypedInput()
        : NoviceInput({.name = "typed words",
                       .controls = training::kTypedControls,
                       .profile = trainer::mouseProfile(),
                       .functions = {.rearm = 0},
                       .push = "push the device",
                       .pull = "draw the device back"}) {}
    double obey(const std::string& prompt) override {
        constexpr double kAgain_s = 3.0;
        const std::size_t open = prompt.find('"');
        if (open != std::string::npos)
            typed_ += prompt.substr(open + 1, prompt.find('"', open + 1) - open - 1) + "\n";
        return kAgain_s;
    }
    std::string typed() override { return std::exchange(typed_, {}); }

  private:
    std::string typed_;
};

#if defined(STYLET_WINDOW)
class KeyInput final : public NoviceInput {
  public:
    explicit KeyInput(training::Course course)
        : NoviceInput({.name = "mouse and keys",
                       .controls = training::kMouseControls,
                       .profile = trainer::mouseProfile(),
                       .functions = {.rearm = 0},
                       .push = "Page Down",
                       .pull = "Page Up"}) {
        port_->enableToolInput();
        keys_.setCourse(course);
    }
    // Presses a key that has one letter. The others move the tool.
    double obey(const std::string& prompt) override {
        constexpr std::string_view kPress = "press ";
        const std::size_t at = prompt.find(kPress), letter = at + kPress.size();
        const auto isLetter = [&](std::size_t i) {
            return i < prompt.size() && std::isalnum(static_cast<unsigned char>(prompt[i])) != 0;
        };
        if (at != std::string::npos && isLetter(letter) && !isLetter(letter + 1)) {
            trainer::KeyPress press;
            press.key = char(std::tolower(static_cast<unsigned char>(prompt[letter])));
            keys_.press(press);
        }
        return kPatient_s;
    }
    std::string typed() override { return port_->typed(); }

  private:
    std::shared_ptr<trainer::WindowPort> port_ = std::make_shared<trainer::WindowPort>();
    trainer::WindowKeys keys_{port_};
};
#endif

class ControllerInput final : public NoviceInput {
  public:
    ControllerInput()
        : NoviceInput({.name = "controllers",
                       .controls = training::kControllerControls,
                       .profile = trainer::controllerProfile(),
                       .functions = trainer::kControllerFunctions,
                       .push = "move your hand",
                       .pull = "move your hand back"}) {}
    double obey(const std::string& prompt) override {
        const auto names = [&](const char* what) { return prompt.find(what) != std::string::npos; };
        if (names("the other hand's trigger"))
            other_.select = !names("let go of");
        else if (names("squeeze the other hand"))
            other_.squeeze = 1.0f;
        else if (names("open the other hand"))
            other_.squeeze = 0.0f;
        else if (names("the other hand's menu"))
            other_.menu = true, release_in_ticks_ = kPress_ticks;
        else if (names("hold B (menu)"))
            tool_.menu = true, release_in_ticks_ = kHold_ticks;
        else if (names("press B (menu)"))
            tool_.menu = true, release_in_ticks_ = kPress_ticks;
        else if (names("squeeze"))
            tool_.squeeze = 1.0f, release_in_ticks_ = kPress_ticks;
        return names("until you hold it") ? kImpatient_s : kPatient_s;
    }
    std::uint32_t buttons() override {
        if (release_in_ticks_ > 0 && --release_in_ticks_ == 0) tool_ = {}, other_.menu = false;
        return trainer::controllerButtons(tool_, other_);
    }

  private:
    static constexpr int kPress_ticks = 100, kHold_ticks = 1200;
    trainer::ControllerKeys tool_, other_;
    int release_in_ticks_ = 0;
};

}  // namespace

std::vector<std::unique_ptr<NoviceInput>> makeNoviceInputs([[maybe_unused]] training::Course course) {
    std::vector<std::unique_ptr<NoviceInput>> inputs;
    inputs.push_back(std::make_unique<TypedInput>());
#if defined(STYLET_WINDOW)
    inputs.push_back(std::make_unique<KeyInput>(course));
#endif
    inputs.push_back(std::make_unique<ControllerInput>());
    return inputs;
}

}  // namespace stylet::test
