#include "app/trainer/display/player.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/trainer/stores/console.h"

namespace stylet::trainer {

void Player::execute(std::string lines) {
    while (const std::optional<std::string> line = popLine(lines))
        executeLine(*line);
}

void Player::executeLine(std::string_view line) {
    const std::size_t blank = std::min(line.find(' '), line.size());
    const std::string_view word = line.substr(0, blank);
    if (word == "stop") state_.plays = false;
    if (word == "toggle") {
        state_.plays = !state_.plays;
        if (state_.plays && state_.at_s >= state_.length_s) goTo(0.0);
    }
    if (blank == line.size()) return;
    const auto number = parseNumber<double>(line.substr(blank + 1));
    if (!number || !std::isfinite(*number)) return;
    const double value = *number;
    if (word == "skip") goTo(state_.at_s + value);
    if (word == "seek") goTo(value * state_.length_s);
    if (word == "speed" && value > 0.0) state_.speed = std::clamp(state_.speed * value, kSlowest, kFastest);
}

void Player::goTo(double at_s) {
    state_.at_s = std::clamp(at_s, 0.0, state_.length_s);
}

void Player::advance(double dt_s) {
    if (!state_.plays) return;
    goTo(state_.at_s + state_.speed * dt_s);
    state_.plays = state_.at_s < state_.length_s;
}

std::string PlayerStick::update(std::uint32_t buttons, const std::array<float, 2>& stick, double dt_s) {
    const std::uint32_t fresh = buttons & ~std::exchange(buttons_, buttons);
    std::string commands;
    if (fresh & 1u) commands += "toggle\n";
    if (fresh & 2u) commands += "seek 0\n";
    if (fresh & 4u) commands += "skip " + std::to_string(-kBack_s) + "\n";
    const auto [right, up] = stick;
    if (const float beyond = (std::fabs(right) - kRest) / (1.0f - kRest); beyond > 0.0f) {
        const double rate_s = std::copysign(kFastest_s * double(beyond * beyond), double(right));
        commands += "stop\nskip " + std::to_string(rate_s * dt_s) + "\n";
        return commands;
    }
    if (std::fabs(up) > kFlick && !flicked_) commands += up > 0.0f ? "speed 2\n" : "speed 0.5\n";
    flicked_ = std::fabs(up) > (flicked_ ? kRest : kFlick);
    return commands;
}

}  // namespace stylet::trainer
