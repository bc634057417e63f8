#include "tests/support/browser.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <thread>

namespace stylet::test {

using nlohmann::json;

namespace {

constexpr int kTimeout_ms = 120000;  // long enough for a slow and busy machine

std::vector<std::uint8_t> bytesOfBase64(const std::string& text) {
    std::vector<std::uint8_t> bytes;
    unsigned word = 0;
    int bits = 0;
    for (const char c : text) {
        unsigned digit = 0;
        if (c >= 'A' && c <= 'Z')
            digit = unsigned(c - 'A');
        else if (c >= 'a' && c <= 'z')
            digit = unsigned(c - 'a') + 26;
        else if (c >= '0' && c <= '9')
            digit = unsigned(c - '0') + 52;
        else if (c == '+' || c == '/')
            digit = c == '+' ? 62 : 63;
        else
            continue;
        word = word << 6 | digit, bits += 6;
        if (bits >= 8) bits -= 8, bytes.push_back(std::uint8_t(word >> bits));
    }
    return bytes;
}

// Chromium expects the ends of the pipe at descriptors 3 and 4.
[[noreturn]] void becomeChromium(int in, int out, const std::string& profile) {
    const int high_in = ::fcntl(in, F_DUPFD, 10), high_out = ::fcntl(out, F_DUPFD, 10);
    ::dup2(high_in, 3);
    ::dup2(high_out, 4);
    ::close(high_in);
    ::close(high_out);
    const int null = ::open("/dev/null", O_RDWR);
    for (const int end : {0, 1, 2})
        ::dup2(null, end);
    ::unsetenv("LD_PRELOAD");
    const std::string data = "--user-data-dir=" + profile;
    ::execlp("chromium", "chromium", "--headless=new", "--no-sandbox", "--disable-gpu",
             "--disable-dev-shm-usage", "--disable-extensions", "--disable-background-networking",
             "--no-first-run", "--hide-scrollbars", "--force-device-scale-factor=1",
             "--remote-debugging-pipe", data.c_str(), "about:blank", static_cast<char*>(nullptr));
    ::_exit(127);
}

}  // namespace

Browser::Browser() {
    std::array<int, 2> down{}, up{};
    if (::pipe2(down.data(), O_CLOEXEC) != 0 || ::pipe2(up.data(), O_CLOEXEC) != 0)
        throw std::runtime_error("no pipe");
    process_ = ::fork();
    if (process_ == 0) {
        ::setpgid(0, 0);
        becomeChromium(down[0], up[1], profile_.path().string());
    }
    ::close(down[0]);
    ::close(up[1]);
    to_ = down[1], from_ = up[0];
    const json target = exchange("Target.createTarget", {{"url", "about:blank"}}, "");
    session_ = exchange("Target.attachToTarget", {{"targetId", target.at("targetId")}, {"flatten", true}}, "")
                   .at("sessionId")
                   .get<std::string>();
    for (const char* domain :
         {"Page.enable", "Runtime.enable", "Log.enable", "Network.enable", "Accessibility.enable"})
        callMethod(domain);
}

Browser::~Browser() {
    ::close(to_);
    ::close(from_);
    if (process_ <= 0) return;
    ::kill(-process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
    // Chromium's child processes release the profile folder shortly after it ends.
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
}

json Browser::next() {
    std::size_t end = 0;
    while ((end = in_.find('\0')) == std::string::npos) {
        pollfd wait{from_, POLLIN, 0};
        if (::poll(&wait, 1, kTimeout_ms) <= 0) throw std::runtime_error("Chromium does not answer");
        std::array<char, 65536> part;
        const ssize_t count = ::read(from_, part.data(), part.size());
        if (count <= 0) throw std::runtime_error("Chromium is gone, or is not installed");
        in_.append(part.data(), std::size_t(count));
    }
    json message = json::parse(in_.substr(0, end));
    in_.erase(0, end + 1);
    return message;
}

void Browser::note(const json& event) {
    const std::string method = event.at("method");
    const json& p = event.at("params");
    if (method == "Page.loadEventFired") loaded_ = true;
    if (method == "Runtime.exceptionThrown") complaints_.push_back(p.at("exceptionDetails").dump());
    if (method == "Runtime.consoleAPICalled") complaints_.push_back(p.dump());
    if (method == "Log.entryAdded") complaints_.push_back(p.at("entry").dump());
    if (method == "Network.requestWillBeSent") requests_.push_back(p.at("request").at("url"));
}

json Browser::exchange(const std::string& method, const json& parameters, const std::string& session) {
    json request = {{"id", ++number_}, {"method", method}, {"params", parameters}};
    if (!session.empty()) request["sessionId"] = session;
    const std::string text = request.dump();
    for (std::size_t sent = 0; sent <= text.size();) {  // including the terminating zero
        const ssize_t count = ::write(to_, text.c_str() + sent, text.size() + 1 - sent);
        if (count <= 0) throw std::runtime_error("Chromium is gone, or is not installed");
        sent += std::size_t(count);
    }
    for (;;) {
        const json message = next();
        if (!message.contains("id")) {
            note(message);
        } else if (message.at("id") == number_) {
            if (message.contains("error"))
                throw std::runtime_error(method + ": " + message.at("error").dump());
            return message.at("result");
        }
    }
}

json Browser::callMethod(const std::string& method, const json& parameters) {
    return exchange(method, parameters, session_);
}

void Browser::open(const std::filesystem::path& html, int width, int height, bool scripts) {
    callMethod("Emulation.setDeviceMetricsOverride",
               {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
    callMethod("Emulation.setScriptExecutionDisabled", {{"value", !scripts}});
    complaints_.clear();
    requests_.clear();
    loaded_ = false;
    callMethod("Page.navigate", {{"url", "file://" + std::filesystem::absolute(html).string()}});
    while (!loaded_) {
        const json message = next();
        if (!message.contains("id")) note(message);
    }
    // Wait for two frames, so that everything the scripts have drawn is visible.
    if (scripts)
        callMethod("Runtime.evaluate",
                   {{"expression",
                     "new Promise(r => requestAnimationFrame(() => requestAnimationFrame(() => r(1))))"},
                    {"awaitPromise", true}});
}

json Browser::evaluate(const std::string& expression) {
    const json result = callMethod(
        "Runtime.evaluate", {{"expression", expression}, {"returnByValue", true}, {"awaitPromise", true}});
    if (result.contains("exceptionDetails")) throw std::runtime_error(result.at("exceptionDetails").dump());
    const json& value = result.at("result");
    return value.contains("value") ? value.at("value") : json(nullptr);
}

void Browser::press(const std::string& key, int code) {
    json event = {{"type", "keyDown"}, {"key", key}, {"code", key}, {"windowsVirtualKeyCode", code}};
    if (key == "Enter") event["text"] = "\r";
    callMethod("Input.dispatchKeyEvent", event);
    event["type"] = "keyUp";
    event.erase("text");
    callMethod("Input.dispatchKeyEvent", event);
}

void Browser::screenshot(const std::filesystem::path& png) {
    const json picture =
        callMethod("Page.captureScreenshot", {{"format", "png"}, {"captureBeyondViewport", true}});
    const std::vector<std::uint8_t> bytes = bytesOfBase64(picture.at("data").get<std::string>());
    std::ofstream(png, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

std::vector<Browser::Accessible> Browser::accessibles() {
    const json tree = callMethod("Accessibility.getFullAXTree");
    std::vector<Accessible> all;
    for (const json& node : tree.at("nodes")) {
        if (node.value("ignored", false)) continue;
        const auto text = [&](const char* part) {
            return node.contains(part) && node.at(part).contains("value") &&
                           node.at(part).at("value").is_string()
                       ? node.at(part).at("value").get<std::string>()
                       : std::string();
        };
        all.push_back({text("role"), text("name")});
    }
    return all;
}

}  // namespace stylet::test
