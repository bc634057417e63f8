// The inputs of the scripted novice (novice_test.cpp). Each presses or types what the words of a prompt name,
// and nothing else.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "app/trainer/attempt/commands.h"
#include "app/training/tutor.h"
#include "haptics/tools/device.h"

namespace stylet::test {

struct NoviceInputFacts {
    std::string_view name;
    const training::Controls& controls;
    haptics::DeviceProfile profile;
    trainer::UserButtons functions;
    // The words for a motion along the tool, into the body and back.
    std::string_view push, pull;
};

class NoviceInput {
  public:
    explicit NoviceInput(const NoviceInputFacts& facts_in) : facts(facts_in) {}
    virtual ~NoviceInput() = default;
    // Does once what the prompt names. Returns after how many seconds a novice would try again.
    virtual double obey(const std::string& prompt) = 0;
    // Text since the last call.
    virtual std::string typed() { return {}; }
    // Buttons that are down. Call it once per tick.
    virtual std::uint32_t buttons() { return 0; }

    const NoviceInputFacts facts;
};

// Typed words first, then mouse and keys (if the window is built) and controllers.
std::vector<std::unique_ptr<NoviceInput>> makeNoviceInputs(training::Course);

}  // namespace stylet::test
