// A window with keyboard and mouse input. At most one per process; use from one thread only. Apart from
// Vulkan, only the implementation of this class calls the window system.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

namespace stylet::trainer {

// Digits, lower-case letters and space stand for themselves.
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
    kKeyF1,  // F2 to F12 follow
    kKeyF12 = kKeyF1 + 11
};
struct KeyPress {
    char key = 0;
    bool shift = false;
    std::string text{};    // with key 0: the text that was entered, UTF-8
    bool repeats = false;  // auto-repeat while the key is held down
};

struct Drag {
    double right = 0.0, up = 0.0;       // as fractions of the window's height
    double from_x = 0.0, from_y = 0.0;  // start of the drag, in pixels of the picture
    bool pans = false;                  // true: pan (right button or Shift); false: turn
    bool begins = false;                // the button was just pressed: no motion yet
};

// Events since the last call.
struct WindowEvents {
    std::uint32_t width = 0, height = 0;  // size of the picture in pixels; 0: the window is not visible
    std::vector<KeyPress> keys;
    std::vector<Drag> drags;
    double wheel = 0.0;                 // > 0: away from the user
    bool exposed = false;               // the content must be redrawn
    bool closed = false, lost = false;  // closed by the user; display lost
};

class AppWindow {
  public:
    // Opens a window of this size, or smaller if the monitor is smaller. Throws WindowError.
    AppWindow(const std::string& title, int width, int height);
    ~AppWindow();
    AppWindow(const AppWindow&) = delete;
    AppWindow& operator=(const AppWindow&) = delete;

    std::vector<const char*> instanceExtensions() const;
    VkSurfaceKHR makeSurface(VkInstance);  // throws WindowError
    void setTitle(const std::string&);
    // Waits at most `patience_s` for an event.
    WindowEvents poll(double patience_s);

  private:
    struct Impl;
    Impl* impl_;  // leaked if the display is lost, because objects of a dead connection must not be used
};

}  // namespace stylet::trainer
