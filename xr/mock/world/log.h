// XRMOCK_LOG: one JSON line for each call and each submitted frame. Nothing is formatted if logging is off.
#pragma once

#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include "scenario/json_line.h"
#include "scenario/openxr_api.h"

namespace xrmock {

class Call;
struct Session;
struct SubmittedFrame;

// Guarded by the runtime's mutex. Handles and threads are numbered in order of appearance, so that two runs
// on the virtual clock produce identical bytes.
class Log {
  public:
    explicit Log(const std::string& file_name);  // throws std::runtime_error

    std::string nameOf(const char* kind, std::uint64_t handle);  // "space 2"
    std::size_t threadNumber();
    void write(JsonLine& line);
    void flush();
    const std::string& fileName() const { return file_name_; }

    std::map<std::uint64_t, std::uint64_t> pulses;  // number of the last pulse written, per session
    std::int64_t last_time_ns = 0;                  // time logged for calls without a live instance
    JsonLine line;                                  // the line being written

  private:
    struct Close {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    std::string file_name_;
    std::unique_ptr<std::FILE, Close> file_;
    std::map<std::uint64_t, std::string> names_;
    std::map<std::string, std::uint64_t, std::less<>> counts_;
    std::map<std::thread::id, std::size_t> threads_;
};

// Opens the log named by XRMOCK_LOG. A later instance with the same file name appends to the open log, and
// concurrent instances share it. Throws std::runtime_error.
void openLog();

// Writes {"call": ..., "result": ..., "time": ..., "thread": ..., and the start of "args": [
void beginCallLine(Log& log, const Call& call, XrResult result, std::uint64_t subject);
void endCallLine(Log& log, const Call& call);

// Writes a frame, with the haptic pulses that started since the last frame.
void logFrame(Log& log, const Session& session, const SubmittedFrame& frame);

// Writes {"error": reason}. For errors of the runtime itself, not of a call.
void logError(Log& log, const std::string& reason);

// Appends a structure or a handle to the line.
void describe(Log& log, const XrInstanceCreateInfo& info);
void describe(Log& log, const XrSessionBeginInfo& info);
void describe(Log& log, const XrReferenceSpaceCreateInfo& info);
void describe(Log& log, const XrActionSpaceCreateInfo& info);
void describe(Log& log, const XrViewLocateInfo& info);
void describe(Log& log, const XrSpaceLocation& location);
void describe(Log& log, const XrSwapchainCreateInfo& info);
void describe(Log& log, const XrFrameState& state);
void describe(Log& log, const XrFrameEndInfo& info);
void describe(Log& log, const XrActionSetCreateInfo& info);
void describe(Log& log, const XrActionCreateInfo& info);
void describe(Log& log, const XrActionStateGetInfo& info);
void describe(Log& log, const XrActionStateBoolean& state);
void describe(Log& log, const XrActionStateFloat& state);
void describe(Log& log, const XrActionStateVector2f& state);
void describe(Log& log, const XrHapticActionInfo& info);
void describe(Log& log, const XrHapticBaseHeader& feedback);
void describe(Log& log, const XrEventDataBuffer& event);
void describeText(Log& log, const char* text);

#define XRMOCK_DESCRIBE_HANDLE(Type, kind)                                         \
    inline void describe(Log& log, Type handle) {                                  \
        log.line.text(log.nameOf(kind, reinterpret_cast<std::uintptr_t>(handle))); \
    }
XRMOCK_DESCRIBE_HANDLE(XrInstance, "instance")
XRMOCK_DESCRIBE_HANDLE(XrSession, "session")
XRMOCK_DESCRIBE_HANDLE(XrSpace, "space")
XRMOCK_DESCRIBE_HANDLE(XrSwapchain, "swapchain")
XRMOCK_DESCRIBE_HANDLE(XrActionSet, "action set")
XRMOCK_DESCRIBE_HANDLE(XrAction, "action")
XRMOCK_DESCRIBE_HANDLE(XrDebugUtilsMessengerEXT, "messenger")
XRMOCK_DESCRIBE_HANDLE(XrHandTrackerEXT, "hand tracker")
#undef XRMOCK_DESCRIBE_HANDLE

// Appends one argument of a call to the line. Arguments of other types are omitted. Structures and created
// handles are read only from calls that succeeded, because then they are valid.
template <class Argument>
void describeArgument(Log& log, bool succeeded, Argument argument) {
    if constexpr (std::is_enum_v<Argument>) {
        log.line.number(static_cast<std::int64_t>(argument));
    } else if constexpr (std::is_arithmetic_v<Argument>) {
        log.line.number(argument);
    } else if constexpr (std::is_same_v<Argument, const char*>) {
        describeText(log, argument);
    } else if constexpr (requires { describe(log, argument); }) {
        describe(log, argument);
    } else if constexpr (requires { describe(log, *argument); }) {
        if (succeeded) describe(log, *argument);
    }
}

}  // namespace xrmock
