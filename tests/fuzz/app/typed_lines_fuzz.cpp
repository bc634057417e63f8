#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "app/trainer/attempt/commands.h"
#include "app/trainer/display/player.h"
#include "app/trainer/session/instructor.h"

// Feeds typed input in pieces, as it arrives from a terminal or a window, to the user's, the instructor's
// and the player's command parsers.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet;
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    trainer::Instructor instructor;
    trainer::UserCommands user({}, [](const std::string&) {});
    user.setCourse(training::Course::drainage);  // it has every command
    trainer::Player player(60.0);
    for (std::size_t at = 0; at < text.size(); at += 48) {
        const std::string_view piece = text.substr(at, 48);
        const std::string rest = instructor.processLines(piece);
        user.update(rest, std::uint32_t(at), {});
        player.execute(std::string(piece));
        player.advance(0.25);
        const trainer::Playback& now = player.state();
        if (!(now.at_s >= 0.0 && now.at_s <= 60.0) || !(now.speed >= trainer::Player::kSlowest) ||
            !(now.speed <= trainer::Player::kFastest))
            std::abort();
    }
    for (const haptics::Command& command : instructor.popCommands()) {
        if (command.kind != haptics::CommandKind::breathing) continue;
        const haptics::BreathingScale scale = haptics::breathingScale(command);
        for (const double v : {scale.depth, scale.rate})
            if (!(v >= haptics::kMinBreathingScale && v <= haptics::kMaxBreathingScale)) std::abort();
    }
    return 0;
}
