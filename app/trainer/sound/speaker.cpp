#include "app/trainer/sound/speaker.h"

#include <AL/al.h>
#include <AL/alc.h>
#include <AL/alext.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "app/trainer/sound/alsa_linux.h"

namespace stylet::trainer {
namespace {

// Mixing periods per second. The device's queue has three of them.
constexpr ALCint kMixed_hz = 100;
constexpr const char* kNoOutput = "No Output";  // OpenAL Soft's dummy device
constexpr int kAtOnce = 2;                      // how many instances of one sound may play at the same time
// A silent loop is stopped after this many calls of play(). Mixing has faded it out by then.
constexpr int kSilentPlays = 12;

template <typename Function>
Function extension(ALCdevice* device, const char* name) {
    void* const found = alcGetProcAddress(device, name);
    if (!found) throw SoundError(std::string("OpenAL without ") + name);
    Function function;
    static_assert(sizeof function == sizeof found);
    std::memcpy(&function, &found, sizeof function);
    return function;
}

void setVector(ALuint source, ALenum what, const Vec3& v) {
    alSource3f(source, what, ALfloat(v.x), ALfloat(v.y), ALfloat(v.z));
}

}  // namespace

struct Speaker::Impl {
    Impl(ALCdevice* opened, const std::vector<ALCint>& attributes);
    ~Impl();
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
    void makeSources();
    // The OpenAL context is set per thread, so that two speakers do not interfere.
    void current() const { set_context(context); }

    ALCdevice* device;
    ALCcontext* context = nullptr;
    ALCboolean (*set_context)(ALCcontext*) = nullptr;
    LPALCRENDERSAMPLESSOFT render_samples = nullptr;
    std::string name;
    std::array<ALuint, kSoundCount> buffers{};
    std::array<std::array<ALuint, kAtOnce>, kSoundCount> sources{};
    std::array<int, kSoundCount> next{}, silent{};
};

Speaker::Impl::Impl(ALCdevice* opened, const std::vector<ALCint>& attributes) : device(opened) {
    if (!device) throw SoundError("no device");
    try {
        if (const ALCchar* reported_name = alcGetString(device, ALC_ALL_DEVICES_SPECIFIER))
            name = reported_name;
        if (name == kNoOutput) throw SoundError("no device");
        set_context = extension<ALCboolean (*)(ALCcontext*)>(device, "alcSetThreadContext");
        context = alcCreateContext(device, attributes.data());
        if (!context) throw SoundError("the device \"" + name + "\" does not support the required settings");
        current();
        makeSources();
        if (alGetError() != AL_NO_ERROR) throw SoundError("the device \"" + name + "\" has too few voices");
    } catch (...) {
        if (context) set_context(nullptr), alcDestroyContext(context);
        alcCloseDevice(device);
        throw;
    }
}

Speaker::Impl::~Impl() {
    current();
    for (const auto& both : sources)
        alDeleteSources(kAtOnce, both.data());
    alDeleteBuffers(kSoundCount, buffers.data());
    set_context(nullptr);
    alcDestroyContext(context);
    alcCloseDevice(device);
}

void Speaker::Impl::makeSources() {
    alDistanceModel(AL_INVERSE_DISTANCE_CLAMPED);
    alGenBuffers(kSoundCount, buffers.data());
    for (int i = 0; i < kSoundCount; ++i) {
        const std::size_t at = std::size_t(i);
        std::vector<std::int16_t> samples;
        for (const float s : makeClip(Sound(i)))
            samples.push_back(std::int16_t(s * 32767.0f));
        alBufferData(buffers[at], AL_FORMAT_MONO16, samples.data(),
                     ALsizei(samples.size() * sizeof(samples[0])), kClipRate_hz);
        alGenSources(kAtOnce, sources[at].data());
        for (const ALuint source : sources[at]) {
            alSourcei(source, AL_BUFFER, ALint(buffers[at]));
            alSourcei(source, AL_LOOPING, loops(Sound(i)) ? AL_TRUE : AL_FALSE);
            alSourcef(source, AL_REFERENCE_DISTANCE, 1.0f);
        }
    }
}

Speaker Speaker::device() {
    quietAlsa();
    return Speaker(std::make_unique<Impl>(
        alcOpenDevice(nullptr), std::vector<ALCint>{ALC_FREQUENCY, kClipRate_hz, ALC_REFRESH, kMixed_hz, 0}));
}

Speaker Speaker::loopback() {
    const auto open = extension<LPALCLOOPBACKOPENDEVICESOFT>(nullptr, "alcLoopbackOpenDeviceSOFT");
    // Disable the limiter, which would hide clipping.
    Speaker speaker(std::make_unique<Impl>(
        open(nullptr), std::vector<ALCint>{ALC_FREQUENCY, kClipRate_hz, ALC_FORMAT_CHANNELS_SOFT,
                                           ALC_STEREO_SOFT, ALC_FORMAT_TYPE_SOFT, ALC_FLOAT_SOFT,
                                           ALC_OUTPUT_LIMITER_SOFT, ALC_FALSE, ALC_HRTF_SOFT, ALC_FALSE, 0}));
    speaker.impl_->render_samples =
        extension<LPALCRENDERSAMPLESSOFT>(speaker.impl_->device, "alcRenderSamplesSOFT");
    return speaker;
}

Speaker::Speaker(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Speaker::~Speaker() = default;
Speaker::Speaker(Speaker&&) noexcept = default;
Speaker& Speaker::operator=(Speaker&&) noexcept = default;

void Speaker::play(const SoundFrame& frame) {
    impl_->current();
    for (int i = 0; i < kSoundCount; ++i) {
        const std::size_t at = std::size_t(i);
        const Voice& voice = frame.voices[at];
        const bool begins = (frame.begun & soundBit(Sound(i))) != 0;
        if (!loops(Sound(i)) && !begins) continue;
        ALuint source = impl_->sources[at][0];
        if (begins && !loops(Sound(i))) {
            source = impl_->sources[at][std::size_t(impl_->next[at])];
            impl_->next[at] = (impl_->next[at] + 1) % kAtOnce;
        }
        ALint state = AL_STOPPED;
        alGetSourcei(source, AL_SOURCE_STATE, &state);
        alSourcef(source, AL_GAIN, voice.gain);
        alSourcef(source, AL_PITCH, voice.pitch);
        setVector(source, AL_POSITION, voice.stage_m);
        if (voice.gain > 0.0f) {
            impl_->silent[at] = 0;
            if (begins || state != AL_PLAYING) alSourcePlay(source);
        } else if (state == AL_PLAYING && ++impl_->silent[at] > kSilentPlays) {
            alSourceStop(source);
        }
    }
}

void Speaker::listen(const Pose& stage_from_head) {
    impl_->current();
    const Vec3& at = stage_from_head.position_m;
    const Vec3 forward = stage_from_head.direction({0.0, 0.0, -1.0});
    const Vec3 up = stage_from_head.direction({0.0, 1.0, 0.0});
    const std::array<ALfloat, 6> axes{ALfloat(forward.x), ALfloat(forward.y), ALfloat(forward.z),
                                      ALfloat(up.x),      ALfloat(up.y),      ALfloat(up.z)};
    alListener3f(AL_POSITION, ALfloat(at.x), ALfloat(at.y), ALfloat(at.z));
    alListenerfv(AL_ORIENTATION, axes.data());
}

bool Speaker::connected() const {
    if (!alcIsExtensionPresent(impl_->device, "ALC_EXT_disconnect")) return true;
    ALCint connected = ALC_TRUE;
    alcGetIntegerv(impl_->device, ALC_CONNECTED, 1, &connected);
    return connected == ALC_TRUE;
}

double Speaker::latency_s() const {
    if (!alcIsExtensionPresent(impl_->device, "ALC_SOFT_device_clock")) return 0.0;
    const auto ask = extension<LPALCGETINTEGER64VSOFT>(impl_->device, "alcGetInteger64vSOFT");
    ALCint64SOFT ns = 0;
    ask(impl_->device, ALC_DEVICE_LATENCY_SOFT, 1, &ns);
    return double(ns) * 1e-9;
}

const std::string& Speaker::name() const {
    return impl_->name;
}

void Speaker::render(std::span<float> stereo) {
    impl_->current();
    impl_->render_samples(impl_->device, stereo.data(), ALCsizei(stereo.size() / 2));
}

}  // namespace stylet::trainer
