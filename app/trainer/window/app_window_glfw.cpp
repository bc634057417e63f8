#include "app/trainer/window/app_window.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include <vulkan/vulkan.h>

#define GLFW_INCLUDE_NONE
#define GLFW_INCLUDE_VULKAN
#define GLFW_EXPOSE_NATIVE_X11
#include <GLFW/glfw3.h>
#include <GLFW/glfw3native.h>

#include "app/trainer/window/mirror.h"

namespace stylet::trainer {
namespace {

// GLFW's description of the last error on this thread.
std::string reason() {
    const char* text = nullptr;
    glfwGetError(&text);
    return text ? text : "no reason given";
}

// Error handler. By default Xlib ends the program when the display is lost.
int ignoreIoError(::Display*) {
    return 0;
}
void displayLost(::Display*, void* lost) {
    static_cast<std::atomic<bool>*>(lost)->store(true);
}
// Error handler. A request that the display refuses must not end the program either.
int ignoreXError(::Display*, XErrorEvent*) {
    return 0;
}

std::string utf8(unsigned code) {
    if (code < 0x80) return {char(code)};
    std::string text;
    const int more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    text += char((0xff00u >> (more + 1) & 0xffu) | code >> 6 * more);
    for (int i = more - 1; i >= 0; --i)
        text += char(0x80u | (code >> 6 * i & 0x3fu));
    return text;
}

// Shrinks a window that is larger, with its frame, than the monitor's work area.
void fitToMonitor(GLFWwindow* window) {
    GLFWmonitor* const monitor = glfwGetPrimaryMonitor();
    if (!monitor) return;
    int area_width = 0, area_height = 0, left = 0, top = 0, right = 0, bottom = 0, width = 0, height = 0;
    glfwGetMonitorWorkarea(monitor, nullptr, nullptr, &area_width, &area_height);
    glfwGetWindowFrameSize(window, &left, &top, &right, &bottom);
    glfwGetWindowSize(window, &width, &height);
    const int most_width = area_width - left - right, most_height = area_height - top - bottom;
    if (most_width > 0 && most_height > 0 && (width > most_width || height > most_height))
        glfwSetWindowSize(window, std::min(width, most_width), std::min(height, most_height));
}

}  // namespace

struct AppWindow::Impl {
    GLFWwindow* window = nullptr;
    std::atomic<bool> lost{false};
    WindowEvents events;
    double x = 0.0, y = 0.0, pixels = 1.0;  // pointer in window units; pixels of the picture per unit
    double from_x = 0.0, from_y = 0.0;
    int held = -1;  // pressed mouse button, or -1
    bool shift = false;

    static Impl& of(GLFWwindow* w) { return *static_cast<Impl*>(glfwGetWindowUserPointer(w)); }
    void listen();
    void key(int key, int modifiers, bool repeats);
    void moved(double to_x, double to_y);
};

void AppWindow::Impl::key(int key, int modifiers, bool repeats) {
    constexpr std::pair<int, Key> kOthers[]{
        {GLFW_KEY_LEFT, kKeyLeft},    {GLFW_KEY_RIGHT, kKeyRight},    {GLFW_KEY_UP, kKeyUp},
        {GLFW_KEY_DOWN, kKeyDown},    {GLFW_KEY_PAGE_UP, kKeyPageUp}, {GLFW_KEY_PAGE_DOWN, kKeyPageDown},
        {GLFW_KEY_HOME, kKeyHome},    {GLFW_KEY_END, kKeyEnd},        {GLFW_KEY_BACKSPACE, kKeyBackspace},
        {GLFW_KEY_TAB, kKeyTab},      {GLFW_KEY_ENTER, kKeyEnter},    {GLFW_KEY_KP_ENTER, kKeyEnter},
        {GLFW_KEY_ESCAPE, kKeyEscape}};
    char pressed = 0;
    if (key == GLFW_KEY_SPACE) pressed = ' ';
    if (key >= GLFW_KEY_0 && key <= GLFW_KEY_9) pressed = char('0' + key - GLFW_KEY_0);
    if (key >= GLFW_KEY_KP_0 && key <= GLFW_KEY_KP_9) pressed = char('0' + key - GLFW_KEY_KP_0);
    if (key >= GLFW_KEY_A && key <= GLFW_KEY_Z) pressed = char('a' + key - GLFW_KEY_A);
    if (key >= GLFW_KEY_F1 && key <= GLFW_KEY_F12) pressed = char(kKeyF1 + key - GLFW_KEY_F1);
    for (const auto& [glfw, ours] : kOthers)
        if (key == glfw) pressed = ours;
    if (pressed != 0) events.keys.push_back({pressed, (modifiers & GLFW_MOD_SHIFT) != 0, {}, repeats});
}

void AppWindow::Impl::moved(double to_x, double to_y) {
    int height = 1;
    glfwGetWindowSize(window, nullptr, &height);
    if (held >= 0 && height > 0)
        events.drags.push_back({(to_x - x) / height, (y - to_y) / height, from_x, from_y,
                                shift || held == GLFW_MOUSE_BUTTON_RIGHT, false});
    x = to_x, y = to_y;
}

void AppWindow::Impl::listen() {
    glfwSetWindowUserPointer(window, this);
    glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int modifiers) {
        if (action != GLFW_RELEASE) of(w).key(key, modifiers, action == GLFW_REPEAT);
    });
    glfwSetCharCallback(window, [](GLFWwindow* w, unsigned code) {
        of(w).events.keys.push_back({0, false, utf8(code), false});
    });
    glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int modifiers) {
        Impl& me = of(w);
        glfwGetCursorPos(w, &me.x, &me.y);
        me.held = action == GLFW_PRESS ? button : -1;
        me.shift = modifiers & GLFW_MOD_SHIFT;
        me.from_x = me.x * me.pixels, me.from_y = me.y * me.pixels;
        if (action == GLFW_PRESS)
            me.events.drags.push_back(
                {0.0, 0.0, me.from_x, me.from_y, me.shift || button == GLFW_MOUSE_BUTTON_RIGHT, true});
    });
    glfwSetCursorPosCallback(window,
                             [](GLFWwindow* w, double to_x, double to_y) { of(w).moved(to_x, to_y); });
    glfwSetScrollCallback(window, [](GLFWwindow* w, double, double steps) { of(w).events.wheel += steps; });
    glfwSetWindowRefreshCallback(window, [](GLFWwindow* w) { of(w).events.exposed = true; });
}

AppWindow::AppWindow(const std::string& title, int width, int height) : impl_(new Impl) {
    if (!glfwInit()) {
        delete impl_;
        throw WindowError("no display: " + reason());
    }
    XSetIOErrorHandler(ignoreIoError);
    XSetIOErrorExitHandler(glfwGetX11Display(), displayLost, &impl_->lost);
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    glfwWindowHint(GLFW_FOCUS_ON_SHOW, GLFW_FALSE);
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    impl_->window = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (!impl_->window) {
        const std::string why = reason();
        glfwTerminate();
        delete impl_;
        throw WindowError("no window: " + why);
    }
    // Set this after creating the window, because GLFW sets Xlib's own handler while creating it.
    XSetErrorHandler(ignoreXError);
    fitToMonitor(impl_->window);
    glfwSetWindowSizeLimits(impl_->window, 320, 200, GLFW_DONT_CARE, GLFW_DONT_CARE);
    glfwShowWindow(impl_->window);
    impl_->listen();
}

AppWindow::~AppWindow() {
    if (impl_->lost) return;
    glfwDestroyWindow(impl_->window);
    glfwTerminate();
    delete impl_;
}

std::vector<const char*> AppWindow::instanceExtensions() const {
    std::uint32_t count = 0;
    const char** names = glfwGetRequiredInstanceExtensions(&count);
    return {names, names + count};
}

VkSurfaceKHR AppWindow::makeSurface(VkInstance instance) {
    VkSurfaceKHR surface = VK_NULL_HANDLE;
    if (glfwCreateWindowSurface(instance, impl_->window, nullptr, &surface) != VK_SUCCESS)
        throw WindowError("Vulkan cannot draw into a window here: " + reason());
    return surface;
}

void AppWindow::setTitle(const std::string& title) {
    if (!impl_->lost) glfwSetWindowTitle(impl_->window, title.c_str());
}

WindowEvents AppWindow::poll(double patience_s) {
    if (!impl_->lost) glfwWaitEventsTimeout(patience_s);
    WindowEvents events = std::exchange(impl_->events, {});
    events.lost = impl_->lost;
    if (events.lost) return events;
    int width = 0, height = 0, across = 0;
    glfwGetFramebufferSize(impl_->window, &width, &height);
    glfwGetWindowSize(impl_->window, &across, nullptr);
    if (across > 0) impl_->pixels = double(width) / across;
    if (glfwGetWindowAttrib(impl_->window, GLFW_ICONIFIED)) width = height = 0;
    events.width = std::uint32_t(std::max(0, width)), events.height = std::uint32_t(std::max(0, height));
    events.closed = glfwWindowShouldClose(impl_->window);
    events.lost = impl_->lost;
    return events;
}

}  // namespace stylet::trainer
