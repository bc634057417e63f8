// A headless X server, and simulated user actions on a window on it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <sys/types.h>

namespace stylet::test {

struct Screenshot {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  // packed triples, rows from the top
};

// Starts Xvfb on a free display and sets DISPLAY; the destructor ends the server and unsets the variable.
// Each call below opens its own connection to the server.
class XDisplay {
  public:
    XDisplay(int width, int height);  // throws std::runtime_error
    ~XDisplay();
    XDisplay(const XDisplay&) = delete;
    XDisplay& operator=(const XDisplay&) = delete;

    const std::string& name() const { return name_; }
    // Title of the only window, or empty if there is none.
    std::string title() const;
    Screenshot shot() const;  // content of the only window, or empty if there is none
    void key(const std::string& symbol, int times = 1, bool shift = false) const;
    void wheel(int x, int y, int steps) const;                    // over the window; > 0: away from the user
    void drag(int from_x, int from_y, int to_x, int to_y) const;  // in the window, left button
    void resize(int width, int height) const;
    void close() const;  // requests closing, as a window manager does
    void stop() const;   // pauses the server, so that it does not answer
    void resume() const;
    void kill();

  private:
    std::string name_;
    pid_t server_ = 0;
};

}  // namespace stylet::test
