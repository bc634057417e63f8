#include "world/haptics.h"

#include <utility>

namespace xrmock {

namespace {

template <class Chosen>
void endPulses(Haptics& haptics, std::int64_t now_ns, Chosen chosen) {
    for (HapticPulse& pulse : haptics.pulses)
        if (pulse.end_ns > now_ns && chosen(pulse)) pulse.end_ns = now_ns;
}

}  // namespace

void startPulse(Haptics& haptics, HapticPulse pulse) {
    stopPulses(haptics, 0, pulse.user, pulse.output, pulse.start_ns);
    pulse.number = ++haptics.started;
    haptics.pulses.push_back(std::move(pulse));
    if (haptics.pulses.size() > kMaxPulses) haptics.pulses.pop_front();
}

void stopPulses(Haptics& haptics, std::uint64_t action, User user, std::string_view output,
                std::int64_t now_ns) {
    endPulses(haptics, now_ns, [&](const HapticPulse& pulse) {
        return pulse.user == user && pulse.output == output && (action == 0 || action == pulse.action);
    });
}

void stopAllPulses(Haptics& haptics, std::int64_t now_ns) {
    endPulses(haptics, now_ns, [](const HapticPulse&) { return true; });
}

}  // namespace xrmock
