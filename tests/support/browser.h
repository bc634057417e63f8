// A headless Chromium, driven through the pipe of its DevTools protocol: no port, no network.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/temp_folder.h"

namespace stylet::test {

class Browser {
  public:
    Browser();  // throws std::runtime_error if it does not start
    ~Browser();
    Browser(const Browser&) = delete;
    Browser& operator=(const Browser&) = delete;

    // Opens a file in a window of this size and waits until it is loaded and drawn.
    void open(const std::filesystem::path& html, int width, int height, bool scripts = true);
    // Evaluates an expression in the page. Throws std::runtime_error if the expression throws.
    nlohmann::json evaluate(const std::string& expression);
    // Presses and releases a key: "Tab", "Enter", "ArrowDown".
    void press(const std::string& key, int code);
    // Writes the whole page as a PNG.
    void screenshot(const std::filesystem::path& png);
    // Role and name of an element in the accessibility tree.
    struct Accessible {
        std::string role, name;
    };
    std::vector<Accessible> accessibles();

    // Since open(): console messages, log messages and uncaught exceptions; and all requested URLs.
    const std::vector<std::string>& complaints() const { return complaints_; }
    const std::vector<std::string>& requests() const { return requests_; }

    // Calls any DevTools method on the page.
    nlohmann::json callMethod(const std::string& method,
                              const nlohmann::json& parameters = nlohmann::json::object());

  private:
    nlohmann::json exchange(const std::string& method, const nlohmann::json& parameters,
                            const std::string& session);
    nlohmann::json next();
    void note(const nlohmann::json& event);

    TempFolder profile_;
    pid_t process_ = 0;
    int to_ = -1, from_ = -1, number_ = 0;
    std::string in_, session_;
    bool loaded_ = false;
    std::vector<std::string> complaints_, requests_;
};

}  // namespace stylet::test
