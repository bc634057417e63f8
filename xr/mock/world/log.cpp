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

void writePose(Log& log, const XrPosef& pose) {
    log.line.pose(fromXr(pose));
}

void numbersOf(JsonLine& line, std::initializer_list<double> values) {
    line.open('[');
    for (const double value : values)
        line.number(value);
    line.close(']');
}

const char* layerName(LayerType type) {
    switch (type) {
        case LayerType::projection:
            return "projection";
        case LayerType::quad:
            return "quad";
        case LayerType::cylinder:
            return "cylinder";
    }
    return "other";
}

void logImage(Log& log, const SubmittedImage& image) {
    const XrRect2Di& rect = image.rect;
    log.line.key("image").open('{');
    log.line.key("swapchain").text(log.nameOf("swapchain", image.swapchain->handle));
    log.line.key("index").number(image.image).key("array_index").number(image.array_index);
    log.line.key("format").number(static_cast<std::int64_t>(image.swapchain->images.format));
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
        log.line.key("range")
            .open('[')
            .number(view.depth->min_depth)
            .number(view.depth->max_depth)
            .close(']');
        log.line.key("near_z_m").number(view.depth->near_z_m).key("far_z_m").number(view.depth->far_z_m);
        log.line.close('}');
    }
    log.line.close('}');
}

void logLayer(Log& log, const SubmittedLayer& layer) {
    log.line.open('{').key("type").text(layerName(layer.type)).key("flags").number(layer.flags);
    log.line.key("space").text(log.nameOf("space", layer.space->handle));
    if (layer.type == LayerType::projection) {
        log.line.key("views").open('[');
        for (const SubmittedView& view : layer.views)
            logView(log, view);
        log.line.close(']').close('}');
        return;
    }
    log.line.key("eyes").number(static_cast<int>(layer.eyes)).key("pose").pose(layer.space_from_layer);
    if (layer.type == LayerType::quad) {
        log.line.key("size_m").open('[').number(layer.quad_size_m.width).number(layer.quad_size_m.height);
        log.line.close(']');
    } else {
        log.line.key("radius_m").number(layer.cylinder_radius_m);
        log.line.key("angle_rad").number(layer.cylinder_angle_rad);
        log.line.key("aspect_ratio").number(layer.cylinder_aspect_ratio);
    }
    logImage(log, layer.image);
    log.line.close('}');
}

// Logs the action and the subaction path (null: all) of a successful call.
void describeAction(Log& log, XrAction action, XrPath path) {
    const auto& described = static_cast<const Action&>(*runtime().handles.find(numberOf(action)));
    const std::string* text = described.set.instance.paths.toString(path);
    log.line.key("action");
    describe(log, true, action);
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
    const Instance* instance = instanceOf(runtime().handles.find(subject));
    if (instance != nullptr) log.last_time_ns = instance->clock.now(call.now_ns);
    log.line.clear();
    log.line.open('{').key("call").text(call.function).key("result").text(resultName(result));
    log.line.key("time").number(log.last_time_ns).key("thread").number(log.threadNumber());
    if (instance != nullptr && !instance->clock.is_virtual) {
        log.line.key("took_ns").number(monotonicNs() - call.now_ns);
    }
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
    log.line.open('{').key("frame").number(frame.number);
    log.line.key("session").text(log.nameOf("session", session.handle));
    log.line.key("display_time").number(frame.display_time);
    log.line.key("blend_mode").number(static_cast<std::int64_t>(frame.blend_mode));
    log.line.key("dropped").boolean(session.frames.begun_fate.dropped).key("layers").open('[');
    for (const SubmittedLayer& layer : frame.layers)
        logLayer(log, layer);
    log.line.close(']').key("haptic_pulses").open('[');
    std::uint64_t& written = log.pulses[session.handle];
    for (const HapticPulse& pulse : session.haptics.pulses) {
        if (pulse.number <= written) continue;
        written = pulse.number;
        log.line.open('{').key("action").text(pulse.action_name).key("user").text(userPath(pulse.user));
        log.line.key("start").number(pulse.start_ns).key("end").number(pulse.end_ns);
        log.line.key("amplitude").number(pulse.amplitude).key("frequency_hz").number(pulse.frequency_hz);
        log.line.close('}');
    }
    log.line.close(']').close('}');
    log.write(log.line);
}

void describe(Log& log, bool, const char* text) {
    if (text != nullptr) log.line.text({text, strnlen(text, kMaxLoggedText)});
}

void describe(Log& log, bool succeeded, const XrInstanceCreateInfo* info) {
    if (!succeeded) return;
    log.line.open('{')
        .key("application")
        .text(info->applicationInfo.applicationName)
        .key("extensions")
        .open('[');
    for (std::uint32_t i = 0; i < info->enabledExtensionCount; ++i)
        log.line.text(info->enabledExtensionNames[i]);
    log.line.close(']').close('}');
}

void describe(Log& log, bool succeeded, const XrSessionBeginInfo* info) {
    if (succeeded) log.line.number(static_cast<int>(info->primaryViewConfigurationType));
}

void describe(Log& log, bool succeeded, const XrReferenceSpaceCreateInfo* info) {
    if (!succeeded) return;
    log.line.open('{').key("type").number(static_cast<std::int64_t>(info->referenceSpaceType)).key("pose");
    writePose(log, info->poseInReferenceSpace);
    log.line.close('}');
}

void describe(Log& log, bool succeeded, const XrActionSpaceCreateInfo* info) {
    if (!succeeded) return;
    log.line.open('{');
    describeAction(log, info->action, info->subactionPath);
    log.line.key("pose");
    writePose(log, info->poseInActionSpace);
    log.line.close('}');
}

void describe(Log& log, bool succeeded, const XrViewLocateInfo* info) {
    if (!succeeded) return;
    log.line.open('{').key("space");
    describe(log, true, info->space);
    log.line.key("display_time").number(info->displayTime).close('}');
}

void describe(Log& log, bool succeeded, XrSpaceLocation* location) {
    if (!succeeded) return;
    log.line.open('{').key("flags").number(location->locationFlags).key("pose");
    writePose(log, location->pose);
    log.line.close('}');
}

void describe(Log& log, bool succeeded, const XrSwapchainCreateInfo* info) {
    if (!succeeded) return;
    log.line.open('{').key("format").number(info->format).key("size");
    numbersOf(log.line, {double(info->width), double(info->height)});
    log.line.key("array_size").number(info->arraySize).key("samples").number(info->sampleCount);
    log.line.key("usage").number(info->usageFlags).close('}');
}

void describe(Log& log, bool succeeded, XrFrameState* state) {
    if (!succeeded) return;
    log.line.open('{').key("display_time").number(state->predictedDisplayTime).key("should_render");
    log.line.boolean(state->shouldRender).close('}');
}

void describe(Log& log, bool succeeded, const XrFrameEndInfo* info) {
    if (!succeeded) return;
    log.line.open('{').key("display_time").number(info->displayTime);
    log.line.key("layers").number(info->layerCount).close('}');
}

void describe(Log& log, bool succeeded, const XrActionSetCreateInfo* info) {
    if (succeeded) log.line.text(info->actionSetName);
}

void describe(Log& log, bool succeeded, const XrActionCreateInfo* info) {
    if (succeeded) log.line.text(info->actionName);
}

void describe(Log& log, bool succeeded, const XrActionStateGetInfo* info) {
    if (!succeeded) return;
    log.line.open('{');
    describeAction(log, info->action, info->subactionPath);
    log.line.close('}');
}

void describe(Log& log, bool succeeded, XrActionStateBoolean* state) {
    if (!succeeded) return;
    log.line.open('{').key("active").boolean(state->isActive).key("state").boolean(state->currentState);
    log.line.close('}');
}

void describe(Log& log, bool succeeded, XrActionStateFloat* state) {
    if (!succeeded) return;
    log.line.open('{').key("active").boolean(state->isActive).key("state").number(state->currentState);
    log.line.close('}');
}

void describe(Log& log, bool succeeded, XrActionStateVector2f* state) {
    if (!succeeded) return;
    log.line.open('{').key("active").boolean(state->isActive).key("state");
    numbersOf(log.line, {state->currentState.x, state->currentState.y});
    log.line.close('}');
}

void describe(Log& log, bool succeeded, const XrHapticActionInfo* info) {
    if (!succeeded) return;
    log.line.open('{');
    describeAction(log, info->action, info->subactionPath);
    log.line.close('}');
}

void describe(Log& log, bool succeeded, const XrHapticBaseHeader* feedback) {
    if (!succeeded) return;
    const auto& vibration = *reinterpret_cast<const XrHapticVibration*>(feedback);
    log.line.open('{').key("duration_ns").number(vibration.duration);
    log.line.key("frequency_hz").number(vibration.frequency);
    log.line.key("amplitude").number(vibration.amplitude).close('}');
}

void describe(Log& log, bool succeeded, XrEventDataBuffer* event) {
    if (!succeeded || event->type == XR_TYPE_EVENT_DATA_BUFFER) return;
    log.line.open('{').key("type").text(structureTypeName(event->type));
    if (event->type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
        XrEventDataSessionStateChanged changed;
        std::memcpy(&changed, event, sizeof changed);
        log.line.key("state").text(sessionStateName(changed.state));
    }
    log.line.close('}');
}

}  // namespace xrmock
