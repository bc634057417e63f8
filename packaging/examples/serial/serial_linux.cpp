// Sample driver: a home-made arm on a serial port, for example on a microcontroller board. The arm sends the
// position of its tip [mm] and its buttons as lines "X Y Z BUTTONS", at least ten times a second. It receives
// a force [mN] as lines "X Y Z". --socket names the port; the default is /dev/ttyACM0.
#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "haptics/devices/entry.h"
#include "haptics/devices/permission_linux.h"

namespace stylet::haptics {

namespace {

constexpr std::int64_t kSerialSilent_ns = 100'000'000;  // the connection is lost after this silence
constexpr std::size_t kLongestSerialLine = 80;
constexpr double kSerialReach_m = 0.08;

std::string serialPort(const DeviceOptions& options) {
    return options.socket.empty() ? "/dev/ttyACM0" : options.socket;
}

DeviceProfile serialProfile(const DeviceOptions&) {
    return {.name = "serial",
            .force_peak_n = 3.0,
            .stiffness_n_per_m = 500.0,
            .source = "a sample: replace the values by those of your arm",
            .senses_rotation = false,
            .rate_hz = 250.0,
            .workspace_radius_m = kSerialReach_m};
}

// Returns false for a line that is not four numbers, or whose position is out of reach.
bool parseSerialLine(const std::string& line, DeviceState& state) {
    double values[4];
    const char *at = line.data(), *const end = at + line.size();
    for (double& value : values) {
        while (at != end && *at == ' ')
            ++at;
        const auto [next, error] = std::from_chars(at, end, value);
        if (error != std::errc() || !(std::fabs(value) <= 1e3)) return false;
        at = next;
    }
    const Vec3 position_m = Vec3(values[0], values[1], values[2]) / 1e3;
    if (at != end || values[3] < 0.0 || !(glm::length(position_m) <= 2.0 * kSerialReach_m)) return false;
    state.device_from_stylus.position_m = position_m;
    state.buttons = std::uint32_t(values[3]);
    state.fresh = 1;
    return true;
}

class SerialDriver final : public Driver {
  public:
    SerialDriver(const DeviceOptions& options, const Clock& clock)
        : port_(serialPort(options)), clock_(clock), profile_(serialProfile(options)) {}
    ~SerialDriver() override { close(); }

    const DeviceProfile& profile() const noexcept override { return profile_; }

    DeviceStage open(std::string& why) override {
        close();
        file_ = ::open(port_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
        if (file_ < 0) {
            const int error = errno;
            why = accessProblem(port_, error);
            return error == ENOENT ? DeviceStage::absent : DeviceStage::failed;
        }
        termios mode{};
        if (tcgetattr(file_, &mode) != 0) return fail(why, "is not a serial port");
        cfmakeraw(&mode);
        cfsetspeed(&mode, B115200);
        if (tcsetattr(file_, TCSAFLUSH, &mode) != 0) return fail(why, "does not support 115200 baud");
        received_.clear();
        stage_ = DeviceStage::opening;  // until the first line
        heard_ns_ = clock_.now_ns(clock_.context);
        return stage_;
    }

    DeviceStage exchange(const Vec3& force_n, DeviceState& state, std::string& why) override {
        char bytes[256];
        ssize_t count = 0;
        while ((count = ::read(file_, bytes, sizeof bytes)) > 0)
            received_.append(bytes, std::size_t(count));
        if (count == 0 || errno != EAGAIN) return fail(why, "is gone: plug the arm in again");
        for (std::size_t end = 0; (end = received_.find('\n')) != std::string::npos;) {
            if (parseSerialLine(received_.substr(0, end), state)) {
                heard_ns_ = clock_.now_ns(clock_.context);
                stage_ = DeviceStage::ready;
            }
            received_.erase(0, end + 1);
        }
        if (received_.size() > kLongestSerialLine) received_.clear();
        if (clock_.now_ns(clock_.context) - heard_ns_ > kSerialSilent_ns)
            return fail(why, "is silent: the arm sends no valid line");
        if (!send(force_n)) return fail(why, "does not accept the force");
        return stage_;
    }

    void close() noexcept override {
        if (file_ < 0) return;
        send(Vec3(0.0));
        ::close(file_);
        file_ = -1;
    }

  private:
    bool send(const Vec3& force_n) noexcept {
        char line[80];
        const Vec3 mn = 1e3 * force_n;
        const int length = std::snprintf(line, sizeof line, "%.0f %.0f %.0f\n", mn.x, mn.y, mn.z);
        return ::write(file_, line, std::size_t(length)) == length;
    }
    DeviceStage fail(std::string& why, const char* reason) {
        why = port_ + " " + reason;
        return DeviceStage::failed;
    }

    std::string port_;
    Clock clock_;
    DeviceProfile profile_;
    DeviceStage stage_ = DeviceStage::absent;
    std::string received_;  // bytes after the last whole line
    std::int64_t heard_ns_ = 0;
    int file_ = -1;
};

void findSerial(const DeviceOptions& options, std::vector<FoundDevice>& found) {
    const std::string port = serialPort(options);
    std::error_code error;
    if (std::filesystem::is_character_file(port, error))
        found.push_back({"serial", port, "an arm on a serial port", accessProblem(port)});
}

std::unique_ptr<Driver> makeSerial(const DeviceOptions& options, const Clock& clock) {
    return std::make_unique<SerialDriver>(options, clock);
}

}  // namespace

extern const DeviceEntry kSerialEntry{
    {"serial", "an arm on a serial port (sample)", nullptr}, findSerial, serialProfile, makeSerial};

}  // namespace stylet::haptics
