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

    std::map<std::uint64_t, std::uint64_t> pulses;  // last pulse written, per session
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

// Appends one argument of a call to the line. Arguments of other types are omitted. Structures are read
// only from calls that succeeded, because then they are valid.
template <class Argument>
void describe(Log& log, bool, const Argument& argument) {
    if constexpr (std::is_enum_v<Argument>) {
        log.line.number(static_cast<std::int64_t>(argument));
    } else if constexpr (std::is_arithmetic_v<Argument>) {
        log.line.number(argument);
    }
}
void describe(Log& log, bool succeeded, const char* text);
void describe(Log& log, bool succeeded, const XrInstanceCreateInfo* info);
void describe(Log& log, bool succeeded, const XrSessionBeginInfo* info);
void describe(Log& log, bool succeeded, const XrReferenceSpaceCreateInfo* info);
void describe(Log& log, bool succeeded, const XrActionSpaceCreateInfo* info);
void describe(Log& log, bool succeeded, const XrViewLocateInfo* info);
void describe(Log& log, bool succeeded, XrSpaceLocation* location);
void describe(Log& log, bool succeeded, const XrSwapchainCreateInfo* info);
void describe(Log& log, bool succeeded, XrFrameState* state);
void describe(Log& log, bool succeeded, const XrFrameEndInfo* info);
void describe(Log& log, bool succeeded, const XrActionSetCreateInfo* info);
void describe(Log& log, bool succeeded, const XrActionCreateInfo* info);
void describe(Log& log, bool succeeded, const XrActionStateGetInfo* info);
void describe(Log& log, bool succeeded, XrActionStateBoolean* state);
void describe(Log& log, bool succeeded, XrActionStateFloat* state);
void describe(Log& log, bool succeeded, XrActionStateVector2f* state);
void describe(Log& log, bool succeeded, const XrHapticActionInfo* info);
void describe(Log& log, bool succeeded, const XrHapticBaseHeader* feedback);
void describe(Log& log, bool succeeded, XrEventDataBuffer* event);

#define XRMOCK_DESCRIBE_HANDLE(Type, kind)                                                          \
    inline void describe(Log& log, bool, Type handle) {                                             \
        log.line.text(log.nameOf(kind, reinterpret_cast<std::uintptr_t>(handle)));                  \
    }                                                                                               \
    inline void describe(Log& log, bool succeeded, Type* created) {                                 \
        if (succeeded) log.line.text(log.nameOf(kind, reinterpret_cast<std::uintptr_t>(*created))); \
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

}  // namespace xrmock
