#include "tests/support/x_display.h"

#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/extensions/XTest.h>
#include <X11/keysym.h>
#include <fmt/core.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <stdexcept>

namespace stylet::test {
namespace {

// GLFW treats two presses of a key within a millisecond as one event that was sent twice.
constexpr unsigned long kBetweenKeys_ms = 5;

struct Close {
    void operator()(Display* display) const { XCloseDisplay(display); }
};
using Connection = std::unique_ptr<Display, Close>;

Connection connect(const std::string& name) {
    Connection display(XOpenDisplay(name.c_str()));
    if (!display) throw std::runtime_error("no X server at " + name);
    return display;
}

// Returns the topmost viewable child of the root window, or 0 if there is none.
Window onlyWindow(Display* display) {
    Window root = 0, parent = 0, *children = nullptr, found = 0;
    unsigned count = 0;
    XQueryTree(display, DefaultRootWindow(display), &root, &parent, &children, &count);
    for (unsigned i = 0; i < count; ++i) {
        XWindowAttributes attributes;
        if (XGetWindowAttributes(display, children[i], &attributes) && attributes.map_state == IsViewable)
            found = children[i];
    }
    if (children) XFree(children);
    return found;
}

std::uint8_t channel(unsigned long pixel, unsigned long mask) {
    const int shift = __builtin_ctzl(mask);
    return std::uint8_t((pixel & mask) >> shift);
}

}  // namespace

XDisplay::XDisplay(int width, int height) {
    int number[2];
    if (pipe(number) != 0) throw std::runtime_error("no pipe");
    const std::string end = std::to_string(number[1]);
    const std::string screen = fmt::format("{}x{}x24", width, height);
    server_ = fork();
    if (server_ == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        ::close(number[0]);
        if (!std::freopen("/dev/null", "w", stderr)) _exit(127);
        execlp("Xvfb", "Xvfb", "-noreset", "-displayfd", end.c_str(), "-screen", "0", screen.c_str(),
               nullptr);
        _exit(127);
    }
    ::close(number[1]);
    std::string text;
    for (char c = 0; read(number[0], &c, 1) == 1 && c != '\n';)
        text += c;
    ::close(number[0]);
    if (text.empty()) throw std::runtime_error("Xvfb did not start");
    name_ = ":" + text;
    setenv("DISPLAY", name_.c_str(), 1);
}

XDisplay::~XDisplay() {
    kill();
    unsetenv("DISPLAY");
}

std::string XDisplay::title() const {
    const Connection display = connect(name_);
    const Window window = onlyWindow(display.get());
    XTextProperty property{};
    const Atom name = XInternAtom(display.get(), "_NET_WM_NAME", False);
    if (!window || !XGetTextProperty(display.get(), window, &property, name) || !property.value) return "";
    std::string text(reinterpret_cast<const char*>(property.value), property.nitems);
    XFree(property.value);
    return text;
}

Screenshot XDisplay::shot() const {
    const Connection display = connect(name_);
    const Window window = onlyWindow(display.get());
    XWindowAttributes size;
    if (!window || !XGetWindowAttributes(display.get(), window, &size)) return {};
    XImage* image = XGetImage(display.get(), window, 0, 0, unsigned(size.width), unsigned(size.height),
                              AllPlanes, ZPixmap);
    if (!image) return {};
    Screenshot shot{size.width, size.height, {}};
    shot.rgb.reserve(std::size_t(3) * std::size_t(size.width) * std::size_t(size.height));
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
            const unsigned long pixel = XGetPixel(image, x, y);
            for (const unsigned long mask : {image->red_mask, image->green_mask, image->blue_mask})
                shot.rgb.push_back(channel(pixel, mask));
        }
    XDestroyImage(image);
    return shot;
}

void XDisplay::key(const std::string& symbol, int times, bool shift) const {
    const Connection display = connect(name_);
    const Window window = onlyWindow(display.get());
    if (window) XSetInputFocus(display.get(), window, RevertToPointerRoot, CurrentTime);
    const KeyCode code = XKeysymToKeycode(display.get(), XStringToKeysym(symbol.c_str()));
    const KeyCode shifted = XKeysymToKeycode(display.get(), XK_Shift_L);
    if (shift) XTestFakeKeyEvent(display.get(), shifted, True, CurrentTime);
    for (int i = 0; i < times; ++i) {
        XTestFakeKeyEvent(display.get(), code, True, kBetweenKeys_ms);
        XTestFakeKeyEvent(display.get(), code, False, CurrentTime);
    }
    if (shift) XTestFakeKeyEvent(display.get(), shifted, False, CurrentTime);
    XSync(display.get(), False);
}

void XDisplay::wheel(int x, int y, int steps) const {
    const Connection display = connect(name_);
    const Window window = onlyWindow(display.get()), root = DefaultRootWindow(display.get());
    int left = 0, top = 0;
    Window child = 0;
    XTranslateCoordinates(display.get(), window, root, 0, 0, &left, &top, &child);
    XTestFakeMotionEvent(display.get(), -1, left + x, top + y, CurrentTime);
    for (int i = 0; i < std::abs(steps); ++i) {
        XTestFakeButtonEvent(display.get(), steps > 0 ? 4 : 5, True, CurrentTime);
        XTestFakeButtonEvent(display.get(), steps > 0 ? 4 : 5, False, CurrentTime);
    }
    XSync(display.get(), False);
}

void XDisplay::drag(int from_x, int from_y, int to_x, int to_y) const {
    const Connection display = connect(name_);
    const Window window = onlyWindow(display.get()), root = DefaultRootWindow(display.get());
    int x = 0, y = 0;
    Window child = 0;
    XTranslateCoordinates(display.get(), window, root, 0, 0, &x, &y, &child);
    XTestFakeMotionEvent(display.get(), -1, x + from_x, y + from_y, CurrentTime);
    XTestFakeButtonEvent(display.get(), 1, True, CurrentTime);
    XTestFakeMotionEvent(display.get(), -1, x + (from_x + to_x) / 2, y + (from_y + to_y) / 2, 20);
    XTestFakeMotionEvent(display.get(), -1, x + to_x, y + to_y, 20);
    XTestFakeButtonEvent(display.get(), 1, False, 20);
    XSync(display.get(), False);
}

void XDisplay::resize(int width, int height) const {
    const Connection display = connect(name_);
    XResizeWindow(display.get(), onlyWindow(display.get()), unsigned(width), unsigned(height));
    XSync(display.get(), False);
}

void XDisplay::close() const {
    const Connection display = connect(name_);
    XEvent event{};
    event.xclient.type = ClientMessage;
    event.xclient.window = onlyWindow(display.get());
    event.xclient.message_type = XInternAtom(display.get(), "WM_PROTOCOLS", False);
    event.xclient.format = 32;
    event.xclient.data.l[0] = long(XInternAtom(display.get(), "WM_DELETE_WINDOW", False));
    XSendEvent(display.get(), event.xclient.window, False, NoEventMask, &event);
    XSync(display.get(), False);
}

void XDisplay::stop() const {
    ::kill(server_, SIGSTOP);
}

void XDisplay::resume() const {
    ::kill(server_, SIGCONT);
}

void XDisplay::kill() {
    if (server_ == 0) return;
    ::kill(server_, SIGTERM);  // the server removes its socket when it ends
    resume();
    waitpid(server_, nullptr, 0);
    server_ = 0;
}

}  // namespace stylet::test
