// stylet-bridge-emulator PATH ANSWERS STROKE_M: runs the emulated bridge as a process. After ANSWERS answers
// it kills itself with SIGKILL in the middle of the next one. In two seconds of the driver's clock the stylus
// moves by STROKE_M and back.
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <vector>

#include "tests/support/bridge_emulator.h"

int main(int argc, char** argv) {
    if (argc != 4) return 2;
    const auto answers = std::strtoull(argv[2], nullptr, 10);
    const int listener = stylet::test::listenOn(argv[1]);
    while (true) {
        const int client = ::accept(listener, nullptr, nullptr);
        if (client < 0) return 1;
        stylet::test::BridgeScript script;
        script.stroke_m = std::strtod(argv[3], nullptr);
        script.period_s = 2.0;
        script.time_of_forces = true;
        stylet::test::BridgeEmulator emulator(script);
        std::vector<std::uint8_t> out;
        std::uint8_t bytes[4096];
        for (bool on = true; on;) {
            const ssize_t got = ::recv(client, bytes, sizeof bytes, 0);
            if (got <= 0) break;
            on = emulator.receive({bytes, std::size_t(got)}, stylet::test::monotonicNow_ns(), out);
            const bool dies = emulator.answered() > answers;
            ::send(client, out.data(), dies ? out.size() / 2 : out.size(), MSG_NOSIGNAL);
            if (dies) std::raise(SIGKILL);
            out.clear();
        }
        ::close(client);
    }
}
