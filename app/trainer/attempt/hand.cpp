#include "app/trainer/attempt/hand.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "app/trainer/attempt/random.h"
#include "base/transcendental.h"

namespace stylet::trainer {

using haptics::CommandKind;
using haptics::Trace;

namespace {

constexpr std::int64_t kHandSample_ns = 1'000'000;
constexpr std::size_t kMaxSamples = 3'600'000;
constexpr double kTau = 6.283185307179586;

// Distance covered by time t if the speed rises from 0 to 1 within t = 0..1, following the minimum-jerk step
// 10t^3 - 15t^4 + 6t^5.
double rampDistance(double t) {
    return t * t * t * t * (2.5 - 3.0 * t + t * t);
}

// A move over `distance` (>= 0) with a smooth start, a cruise and a smooth stop. If it is too short for a
// cruise, the speed is reduced.
struct Glide {
    double distance_m = 0.0, speed_m_s = 0.0, ramp_s = 0.0, cruise_s = 0.0;

    Glide(double distance, double speed, double ramp) : distance_m(distance), speed_m_s(speed), ramp_s(ramp) {
        cruise_s = distance / speed - ramp;
        if (cruise_s >= 0.0) return;
        cruise_s = 0.0;
        speed_m_s = distance / ramp;
    }
    double duration_s() const { return 2.0 * ramp_s + cruise_s; }
    double at(double t) const {
        const double stop = t - ramp_s - cruise_s;
        if (t <= 0.0) return 0.0;
        if (t < ramp_s) return speed_m_s * ramp_s * rampDistance(t / ramp_s);
        if (stop <= 0.0) return speed_m_s * (0.5 * ramp_s + (t - ramp_s));
        if (stop < ramp_s) return distance_m - speed_m_s * ramp_s * rampDistance((ramp_s - stop) / ramp_s);
        return distance_m;
    }
};

class Tremor {
  public:
    // The excursion equals the scenario's tremor when all waves of all three axes are at their crests.
    Tremor(const Scenario& s, std::uint64_t seed) : amplitude_m_(s.tremor_m / (kWaves * std::sqrt(3.0))) {
        Random random{seed};
        for (auto& axis : waves_)
            for (Wave& wave : axis) {
                wave.rad_per_s =
                    kTau * (s.tremor_low_hz + (s.tremor_high_hz - s.tremor_low_hz) * random.next());
                wave.phase = kTau * random.next();
            }
    }
    Vec3 at(double t_s) const {
        Vec3 sum(0.0);
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const Wave& w : waves_[axis])
                sum[int(axis)] += amplitude_m_ * detSin(w.rad_per_s * t_s + w.phase);
        return sum;
    }

  private:
    static constexpr int kWaves = 3;
    struct Wave {
        double rad_per_s = 0.0, phase = 0.0;
    };
    std::array<std::array<Wave, kWaves>, 3> waves_{};
    double amplitude_m_;
};

// Position of the tip relative to the path's entry, and orientation of the tool relative to the path.
struct Offset {
    Vec3 m{0.0};    // depth along the path, headward, frontward
    Vec3 rad{0.0};  // headward, frontward, about the shaft
};

// Generates the trace by playing the stages one after the other.
class Script {
  public:
    Script(const Scenario& s, const patient::PlannedPath& path, const haptics::SimulationSettings& settings,
           std::uint64_t seed, double capsule_m)
        : path_(path),
          length_m_(glm::length(path.target_m - path.entry_m)),
          axis_((path.target_m - path.entry_m) / length_m_),
          headward_(across(Vec3(0, 0, 1), Vec3(1, 0, 0))),
          frontward_(glm::normalize(glm::cross(headward_, axis_))),
          capsule_m_(capsule_m),
          device_from_patient_(settings.patient_from_device.inverse()),
          guide_(settings.tools.guide),
          tremor_(s, seed),
          ramp_s_(s.ramp_s),
          name_(s.name),
          case_(s.patient_case.get()),
          tool_(s.tool) {
        if (frontward_.y < 0.0) frontward_ = -frontward_;
        at_ = offsetOf(s.start);
    }

    void play(const Stage& stage, double longest_breath_s) {
        switch (stage.kind) {
            case StageKind::wait:
                return wait(stage.seconds);
            case StageKind::move:
                return move(stage.to, stage.speed_m_s);
            case StageKind::hold:
                command(CommandKind::holdBreath);
                return wait(longest_breath_s + stage.seconds);
            case StageKind::breathe:
                return command(CommandKind::breathe);
            case StageKind::changeTool:
                return changeTool(stage.tool, stage.seconds);
            case StageKind::park:
                return command(CommandKind::park, 1);
            case StageKind::lift:
                return command(CommandKind::park, 0);
            case StageKind::aspirate:
                return command(CommandKind::aspirate);
            case StageKind::inject:
            case StageKind::numb:
                return inject(stage.kind, stage.injected_m3_per_s, stage.seconds);
            case StageKind::pedal:
                return command(stage.pedal_down ? training::kPedalDown : training::kPedalUp);
            case StageKind::review:
                return review(stage.answers);
            case StageKind::machine:
                for (const training::KnobSetting& t : stage.turned)
                    command(training::knobCommand(t.machine, t.knob, t.value));
        }
    }
    Trace finish() {
        add(at_);
        return std::move(trace_);
    }

  private:
    void wait(double seconds) {
        const auto samples = std::int64_t(std::ceil(seconds * 1000.0));
        for (std::int64_t i = 0; i < samples; ++i)
            add(at_);
    }
    void move(const Place& to, double speed_m_s) {
        const Offset there = offsetOf(to);
        const Vec3 way = there.m - at_.m, turn = there.rad - at_.rad;
        const double length = glm::length(way);
        const Glide glide(length, speed_m_s, ramp_s_), turning(1.0, 1e9, 0.5 * glide.duration_s());
        const Vec3 direction = length > 0.0 ? way / length : Vec3(0.0);
        const auto samples = std::int64_t(std::ceil(glide.duration_s() * 1000.0));
        for (std::int64_t i = 1; i <= samples; ++i) {
            const double t_s = double(i) * 0.001;
            add(Offset{at_.m + direction * glide.at(t_s), at_.rad + turn * turning.at(t_s)});
        }
        at_.m += way;
        at_.rad += turn;
    }
    // Switches the tool and turns the hand smoothly to the new tool's pose.
    void changeTool(haptics::Tool tool, double seconds) {
        command(CommandKind::tool, std::uint32_t(tool));
        const haptics::Tool last = tool_;
        tool_ = tool;
        const auto samples = std::int64_t(std::ceil(seconds * 1000.0));
        for (std::int64_t i = 1; i <= samples; ++i) {
            const double t = double(i) / double(samples), share = t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
            const Pose from = toolPose(last, at_), to = toolPose(tool, at_);
            add({glm::slerp(from.rotation, to.rotation, share),
                 glm::mix(from.position_m, to.position_m, share)});
        }
    }
    void command(CommandKind kind, std::uint32_t value = 0) { command(haptics::Command{kind, value}); }
    void command(const haptics::Command& c) { trace_.commands.push_back({now_ns(), c}); }
    void inject(StageKind kind, double m3_per_s, double seconds) {
        const auto make = kind == StageKind::inject ? training::injectCommand : training::anaesthetiseCommand;
        command(make(m3_per_s));
        if (seconds <= 0.0) return;
        wait(seconds);
        command(make(0.0));
    }
    void review(ReviewAnswers how) {
        constexpr double kRead_s = 0.2;
        if (!case_) return;
        for (int i = 0; i < training::kQuestionCount; ++i) {
            const bool right = training::rightAnswer(*case_, training::Question(i));
            const bool yes = how == ReviewAnswers::yes || (how == ReviewAnswers::right && right) ||
                             (how == ReviewAnswers::wrong && !right);
            wait(kRead_s);
            command(yes ? training::kYes : training::kNo);
        }
        wait(kRead_s);
    }
    // Returns the unit vector along the component of `v` perpendicular to the path. If `v` is nearly parallel
    // to the path, uses `otherwise` in its place.
    Vec3 across(const Vec3& v, const Vec3& otherwise) const {
        const Vec3 part = v - axis_ * glm::dot(v, axis_);
        const Vec3 other = otherwise - axis_ * glm::dot(otherwise, axis_);
        return glm::normalize(glm::length(part) > 0.1 ? part : other);
    }
    Offset offsetOf(const Place& p) const {
        return {{p.share * (p.to_capsule ? capsule_m_ : length_m_) + p.deeper_m, p.headward_m, p.frontward_m},
                {p.headward_rad, p.frontward_rad, p.roll_rad}};
    }
    std::int64_t now_ns() const { return std::int64_t(trace_.samples.size()) * kHandSample_ns; }
    Pose toolPose(haptics::Tool tool, const Offset& at) const {
        const Vec3 tip = path_.entry_m + axis_ * at.m.x + headward_ * at.m.y + frontward_ * at.m.z +
                         tremor_.at(double(now_ns()) * 1e-9);
        return toolPoseFromNeedle(turned(tip, at.rad), tool, guide_);
    }
    Pose turned(const Vec3& tip, const Vec3& rad) const {
        if (rad == Vec3(0.0)) return needlePose(tip, axis_);
        const auto slope = [](double angle) { return detSin(angle) / detCos(angle); };
        Pose needle =
            needlePose(tip, glm::normalize(axis_ + headward_ * slope(rad.x) + frontward_ * slope(rad.y)));
        const double half = 0.5 * rad.z;
        needle.rotation = needle.rotation * Quat{detCos(half), 0.0, 0.0, detSin(half)};
        return needle;
    }
    void add(const Offset& at) { add(toolPose(tool_, at)); }
    void add(const Pose& patient_from_stylus) {
        if (trace_.samples.size() >= kMaxSamples)
            throw DataError(name_, "stage", "together they last more than an hour");
        trace_.samples.push_back({now_ns(), device_from_patient_ * patient_from_stylus, 0});
    }

    const patient::PlannedPath& path_;
    double length_m_;
    Vec3 axis_, headward_, frontward_;
    double capsule_m_;
    Pose device_from_patient_;
    haptics::GuideSettings guide_;
    Tremor tremor_;
    double ramp_s_;
    std::string name_;
    const training::PatientCase* case_;
    haptics::Tool tool_;
    Offset at_;
    Trace trace_;
};

}  // namespace

Trace makeScriptedTrace(const Scenario& s, const patient::PlannedPath& path, double longest_breath_s,
                        const haptics::SimulationSettings& settings, std::uint64_t seed, double capsule_m) {
    Script script(s, path, settings, seed, capsule_m);
    for (const Stage& stage : s.stages)
        script.play(stage, longest_breath_s);
    return script.finish();
}

Pose placeDeviceBeside(const Grid& grid) {
    constexpr double kStandOff_m = 0.2;
    const Vec3 last = grid.centre(grid.dims - 1), middle = 0.5 * (grid.origin_m + last);
    // Columns: the device's x, y, z axes in the patient frame (toward feet, front, right).
    const glm::dmat3 axes(Vec3(0, 0, -1), Vec3(0, 1, 0), Vec3(1, 0, 0));
    return {glm::quat_cast(axes), Vec3(last.x + kStandOff_m, middle.y, middle.z)};
}

}  // namespace stylet::trainer
