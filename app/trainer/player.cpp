#include "app/trainer/player.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace stylet::trainer {

void Player::hear(std::string_view lines) {
    for (std::size_t end; (end = lines.find('\n')) != std::string_view::npos; lines.remove_prefix(end + 1))
        hearLine(lines.substr(0, end));
}

void Player::hearLine(std::string_view line) {
    const std::size_t blank = std::min(line.find(' '), line.size());
    const std::string_view word = line.substr(0, blank);
    if (word == "stop") state_.plays = false;
    if (word == "toggle") {
        state_.plays = !state_.plays;
        if (state_.plays && state_.at_s >= state_.length_s) goTo(0.0);
    }
    if (blank == line.size()) return;
    double value = 0.0;
    const char* const last = line.data() + line.size();
    const auto [end, error] = std::from_chars(line.data() + blank + 1, last, value);
    if (error != std::errc() || end != last || !std::isfinite(value)) return;
    if (word == "skip") goTo(state_.at_s + value);
    if (word == "seek") goTo(value * state_.length_s);
    if (word == "speed" && value > 0.0) state_.speed = std::clamp(state_.speed * value, kSlowest, kFastest);
}

void Player::goTo(double at_s) {
    state_.at_s = std::clamp(at_s, 0.0, state_.length_s);
}

void Player::pass(double dt_s) {
    if (!state_.plays) return;
    goTo(state_.at_s + state_.speed * dt_s);
    state_.plays = state_.at_s < state_.length_s;
}

}  // namespace stylet::trainer
