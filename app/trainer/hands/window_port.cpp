#include "app/trainer/hands/window_port.h"

#include <algorithm>

namespace stylet::trainer {

bool WindowPort::pushLine(std::string_view text) noexcept {
    Line line;
    line.length = std::uint8_t(std::min(text.size(), kMaxLineLength));
    std::copy_n(text.begin(), line.length, line.text.begin());
    return lines_.push(line);
}

std::string WindowPort::typed() {
    std::string text;
    for (Line line; lines_.pop(line);)
        text.append(line.text.data(), line.length) += '\n';
    return text;
}

Playback WindowPort::playback() noexcept {
    Playback now;
    playback_.read(now);
    return now;
}

void WindowPort::publish(haptics::Tool tool, double force_n) noexcept {
    tool_.store(tool, std::memory_order_relaxed);
    pressing_n_.store(force_n, std::memory_order_relaxed);
}

}  // namespace stylet::trainer
