#include "world/log.h"

#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "scenario/names.h"
#include "world/call.h"
#include "world/objects.h"
#include "world/observers.h"
#include "world/submitted_frame.h"

namespace xrmock {

namespace {

constexpr std::size_t kBufferBytes = 1U << 16;
constexpr std::size_t kMaxLoggedText = 256;

void writeNumbers(JsonLine& line, std::initializer_list<double> values) {
    line.open('[');
    for (const double value : values)
        line.number(value);
    line.close(']');
}

constexpr const char* kLayerNames[] = {"projection", "quad", "cylinder"};  // by LayerType

void logImage(Log& log, const SubmittedImage& image) {
    const XrRect2Di& rect = image.rect;
    log.line.key("image").open('{');
    log.line.fields("swapchain", log.nameOf("swapchain", image.swapchain->handle), "index", image.image,
                    "array_index", image.array_index, "format", image.swapchain->images.format);
    log.line.key("rect").open('[').number(rect.offset.x).number(rect.offset.y);
    log.line.number(rect.extent.width).number(rect.extent.height).close(']').close('}');
}

void logView(Log& log, const SubmittedView& view) {
    log.line.open('{').key("pose").pose(view.space_from_eye);
    log.line.key("fov").open('[').number(view.fov.angleLeft).number(view.fov.angleRight);
    log.line.number(view.fov.angleUp).number(view.fov.angleDown).close(']');
    logImage(log, view.image);
    if (view.depth) {
        log.line.key("depth").open('{');
        logImage(log, view.depth->image);
        log.line.key("range").open('[').number(view.depth->min_depth).number(view.depth->max_depth);
        log.line.close(']');
        log.line.fields("near_z_m", view.depth->near_z_m, "far_z_m", view.depth->far_z_m).close('}');
    }
    log.line.close('}');
}

void logLayer(Log& log, const SubmittedLayer& layer) {
    log.line.open('{').fields("type", kLayerNames[static_cast<std::size_t>(layer.type)], "flags", layer.flags,
                              "space", log.nameOf("space", layer.space->handle));
    if (layer.type == LayerType::projection) {
        log.line.key("views").open('[');
        for (const SubmittedView& view : layer.views)
            logView(log, view);
        log.line.close(']').close('}');
        return;
    }
    log.line.fields("eyes", layer.eyes, "pose", layer.space_from_layer);
    if (layer.type == LayerType::quad) {
        log.line.key("size_m").open('[').number(layer.quad_size_m.width).number(layer.quad_size_m.height);
        log.line.close(']');
    } else {
        log.line.fields("radius_m", layer.cylinder_radius_m, "angle_rad", layer.cylinder_angle_rad,
                        "aspect_ratio", layer.cylinder_aspect_ratio);
    }
    logImage(log, layer.image);
    log.line.close('}');
}

// Logs the action and the subaction path (null: all) of a successful call.
void describeAction(Log& log, XrAction action, XrPath path) {
    const auto& described = static_cast<const Action&>(*runtime().handles.find(handleValue(action)));
    const std::string* text = described.set.instance.paths.toString(path);
    log.line.key("action");
    describe(log, action);
    log.line.key("path");
    text == nullptr ? log.line.null() : log.line.text(*text);
}

}  // namespace

Log::Log(const std::string& file_name) : file_name_(file_name), file_(std::fopen(file_name.c_str(), "wb")) {
    if (!file_) throw std::runtime_error("XRMOCK_LOG: " + file_name + " cannot be written");
    std::setvbuf(file_.get(), nullptr, _IOFBF, kBufferBytes);
}

std::string Log::nameOf(const char* kind, std::uint64_t handle) {
    if (handle == 0) return "null";
    std::string& name = names_[handle];
    if (name.empty()) name = std::string(kind) + " " + std::to_string(++counts_[kind]);
    return name;
}

std::size_t Log::threadNumber() {
    return threads_.try_emplace(std::this_thread::get_id(), threads_.size() + 1).first->second;
}

void Log::write(JsonLine& written) {
    std::fwrite(written.str().data(), 1, written.str().size(), file_.get());
    std::fputc('\n', file_.get());
    written.clear();
}

void Log::flush() {
    std::fflush(file_.get());
}

void openLog() {
    if (runtime().instances > 1) return;
    const char* file = std::getenv("XRMOCK_LOG");
    const std::string name = file == nullptr ? "" : file;
    std::unique_ptr<Log>& log = runtime().log;
    if (log && log->fileName() == name) {
        log->last_time_ns = 0;
        return;
    }
    log.reset();  // flush and close before the same file may be reopened
    if (!name.empty()) log = std::make_unique<Log>(name);
}

void beginCallLine(Log& log, const Call& call, XrResult result, std::uint64_t subject) {
    const Instance* instance = findInstance(runtime().handles.find(subject));
    if (instance != nullptr) log.last_time_ns = instance->clock.now(call.now_ns);
    log.line.clear();
    log.line.open('{').fields("call", call.function, "result", resultName(result), "time", log.last_time_ns,
                              "thread", log.threadNumber());
    if (instance != nullptr && !instance->clock.is_virtual)
        log.line.key("took_ns").number(monotonicNs() - call.now_ns);
    log.line.key("args").open('[');
}

void endCallLine(Log& log, const Call& call) {
    log.line.close(']').close('}');
    log.write(log.line);
    // Flush once per frame, so that the file is complete even if the application crashes between frames.
    const std::string_view function = call.function;
    if (function == "xrEndFrame" || function == "xrDestroyInstance") log.flush();
}

void logFrame(Log& log, const Session& session, const SubmittedFrame& frame) {
    log.line.clear();
    log.line.open('{').fields("frame", frame.number, "session", log.nameOf("session", session.handle),
                              "display_time", frame.display_time, "blend_mode", frame.blend_mode, "dropped",
                              session.frames.begun_override.dropped);
    log.line.key("layers").open('[');
    for (const SubmittedLayer& layer : frame.layers)
        logLayer(log, layer);
    log.line.close(']').key("haptic_pulses").open('[');
    std::uint64_t& written = log.pulses[session.handle];
    for (const HapticPulse& pulse : session.haptics.pulses) {
        if (pulse.number <= written) continue;
        written = pulse.number;
        log.line.object("action", pulse.action_name, "user", userPath(pulse.user), "start", pulse.start_ns,
                        "end", pulse.end_ns, "amplitude", pulse.amplitude, "frequency_hz",
                        pulse.frequency_hz);
    }
    log.line.close(']').close('}');
    log.write(log.line);
}

void logError(Log& log, const std::string& reason) {
    log.line.clear();
    log.line.object("error", reason);
    log.write(log.line);
}

void describeText(Log& log, const char* text) {
    if (text != nullptr) log.line.text({text, strnlen(text, kMaxLoggedText)});
}

void describe(Log& log, const XrInstanceCreateInfo& info) {
    log.line.open('{')
        .fields("application", info.applicationInfo.applicationName)
        .key("extensions")
        .open('[');
    for (std::uint32_t i = 0; i < info.enabledExtensionCount; ++i)
        log.line.text(info.enabledExtensionNames[i]);
    log.line.close(']').close('}');
}

void describe(Log& log, const XrSessionBeginInfo& info) {
    log.line.number(static_cast<int>(info.primaryViewConfigurationType));
}

void describe(Log& log, const XrReferenceSpaceCreateInfo& info) {
    log.line.object("type", info.referenceSpaceType, "pose", fromXr(info.poseInReferenceSpace));
}

void describe(Log& log, const XrActionSpaceCreateInfo& info) {
    log.line.open('{');
    describeAction(log, info.action, info.subactionPath);
    log.line.fields("pose", fromXr(info.poseInActionSpace)).close('}');
}

void describe(Log& log, const XrViewLocateInfo& info) {
    log.line.open('{').key("space");
    describe(log, info.space);
    log.line.key("display_time").number(info.displayTime).close('}');
}

void describe(Log& log, const XrSpaceLocation& location) {
    log.line.object("flags", location.locationFlags, "pose", fromXr(location.pose));
}

void describe(Log& log, const XrSwapchainCreateInfo& info) {
    log.line.open('{').key("format").number(info.format).key("size");
    writeNumbers(log.line, {double(info.width), double(info.height)});
    log.line.fields("array_size", info.arraySize, "samples", info.sampleCount, "usage", info.usageFlags);
    log.line.close('}');
}

void describe(Log& log, const XrFrameState& state) {
    log.line.object("display_time", state.predictedDisplayTime, "should_render",
                    state.shouldRender != XR_FALSE);
}

void describe(Log& log, const XrFrameEndInfo& info) {
    log.line.object("display_time", info.displayTime, "layers", info.layerCount);
}

void describe(Log& log, const XrActionSetCreateInfo& info) {
    log.line.text(info.actionSetName);
}

void describe(Log& log, const XrActionCreateInfo& info) {
    log.line.text(info.actionName);
}

void describe(Log& log, const XrActionStateGetInfo& info) {
    log.line.open('{');
    describeAction(log, info.action, info.subactionPath);
    log.line.close('}');
}

void describe(Log& log, const XrActionStateBoolean& state) {
    log.line.object("active", state.isActive != XR_FALSE, "state", state.currentState != XR_FALSE);
}

void describe(Log& log, const XrActionStateFloat& state) {
    log.line.object("active", state.isActive != XR_FALSE, "state", state.currentState);
}

void describe(Log& log, const XrActionStateVector2f& state) {
    log.line.open('{').key("active").boolean(state.isActive).key("state");
    writeNumbers(log.line, {state.currentState.x, state.currentState.y});
    log.line.close('}');
}

void describe(Log& log, const XrHapticActionInfo& info) {
    log.line.open('{');
    describeAction(log, info.action, info.subactionPath);
    log.line.close('}');
}

void describe(Log& log, const XrHapticBaseHeader& feedback) {
    const auto& vibration = reinterpret_cast<const XrHapticVibration&>(feedback);
    log.line.object("duration_ns", vibration.duration, "frequency_hz", vibration.frequency, "amplitude",
                    vibration.amplitude);
}

void describe(Log& log, const XrEventDataBuffer& event) {
    if (event.type == XR_TYPE_EVENT_DATA_BUFFER) return;
    log.line.open('{').key("type").text(structureTypeName(event.type));
    if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
        XrEventDataSessionStateChanged changed;
        std::memcpy(&changed, &event, sizeof changed);
        log.line.key("state").text(sessionStateName(changed.state));
    }
    log.line.close('}');
}

}  // namespace xrmock
