// A window with keys and a mouse. One a process, one thread. The only file that talks to the window system,
// but for what Vulkan says to it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

namespace stylet::trainer {

// Digits, lower-case letters and the space are themselves.
enum Key : char {
    kKeyLeft = 1,
    kKeyRight,
    kKeyUp,
    kKeyDown,
    kKeyPageUp,
    kKeyPageDown,
    kKeyHome,
    kKeyEnd,
    kKeyBackspace,
    kKeyTab,
    kKeyEnter,
    kKeyEscape,
    kKeyF1,  // and the eleven that follow it
    kKeyF12 = kKeyF1 + 11
};
struct KeyPress {
    char key = 0;
    bool shift = false;
    std::string text{};    // with key 0: what it meant, UTF-8
    bool repeats = false;  // it is held down
};

struct Drag {
    double right = 0.0, up = 0.0;       // in shares of the window's height
    double from_x = 0.0, from_y = 0.0;  // where it began, in pixels of the picture
    bool pans = false;                  // the right button, or with Shift; else it turns
    bool begins = false;                // the button went down: no way yet
};

// Since the last call.
struct WindowNews {
    std::uint32_t width = 0, height = 0;  // of the picture, in pixels; 0: nothing is to be seen
    std::vector<KeyPress> keys;
    std::vector<Drag> drags;
    double wheel = 0.0;                 // > 0: away from the user
    bool exposed = false;               // it has to be drawn again
    bool closed = false, lost = false;  // by the user; the display is gone
};

class AppWindow {
  public:
    // Throws WindowError.
    AppWindow(const std::string& title, int width, int height);
    ~AppWindow();
    AppWindow(const AppWindow&) = delete;
    AppWindow& operator=(const AppWindow&) = delete;

    std::vector<const char*> instanceExtensions() const;
    VkSurfaceKHR makeSurface(VkInstance);  // throws WindowError
    void setTitle(const std::string&);
    // Waits no longer than `patience_s` for something to happen.
    WindowNews poll(double patience_s);

  private:
    struct Impl;
    Impl* impl_;  // stays when the display is lost: nothing of a dead connection may be touched
};

}  // namespace stylet::trainer
