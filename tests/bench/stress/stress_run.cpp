#include "tests/bench/stress/stress_run.h"

#include <algorithm>
#include <cmath>

#include "haptics/devices/profiles.h"
#include "haptics/devices/replay.h"

namespace stylet::stress {

using namespace haptics;
using namespace test;

namespace {

double length(const Vec3& v) {
    return std::sqrt(glm::dot(v, v));
}

// State at the end of a tick.
struct TickState {
    TickOutput out;
    BodyState body;
    Vec3 tissue_m{0.0};  // displacement of the tissue by breathing
    double scale = 0.0;  // factor on the model's force: gain times ramp
    double lateral_j = 0.0;
    StoredEnergy stored;
};

// Displacement of the tissue by breathing [m]. The shared patients move as a rigid whole.
Vec3 tissueAt(const patient::Patient& patient, const patient::Surrogate& breath) {
    const patient::SurrogateRange& v = patient.package().motion.v;
    return {0.0, 0.0, kTravel_m * std::clamp(breath.v, v.low, v.high)};
}

// Increase of the energy [J] stored in the model's springs since the previous tick. It is computed from
// force, depth and lateral energy (Eqs. 1 and 7), without the model's own energy account. At an event, and
// when the phase or the tissue changes, the two ticks have different springs. The function then returns the
// work against the mean force. While the hand feels only a share of the force (stored_energy.h), the springs
// return only that share, and the account is taken over; stored_energy_test.cpp judges it by the hand's work.
double storedRise(const TickState& a, const TickState& b, const patient::TissueTable& table,
                  const Vec3& moved_m) {
    const TickOutput &o = a.out, &n = b.out;
    if (n.tool_force.event || o.phase != n.phase || o.tissue != n.tissue)
        return -0.5 * a.stored.share() * glm::dot(o.tool_force.force_n + n.tool_force.force_n, moved_m);
    if (a.stored.share() < 1.0 || b.stored.share() < 1.0) return b.stored.by_hand_j - a.stored.by_hand_j;
    const double lateral_j = b.lateral_j - a.lateral_j;
    if (n.phase == Phase::pass) {
        const double k = table[std::size_t(n.tissue)].stiffness_n_per_m;
        return k > 0.0 ? lateral_j + 0.5 * (n.force_n * n.force_n - o.force_n * o.force_n) / k : lateral_j;
    }
    return lateral_j + 0.5 * (o.force_n + n.force_n) * (n.depth_m - o.depth_m);
}

class Judge {
  public:
    Judge(const StressCase& c, const CaseInput& staged, const Tissues& tissues, double gain)
        : case_(c),
          staged_(staged),
          patient_(tissues.at(c.tissues)),
          gain_(gain),
          tangent_n_per_m_(gain * staged.settings.output.model_tangent_n_per_m) {
        result_.bare_ratio = ratio(c.damping_n_s_per_m);
        result_.held_ratio = ratio(c.damping_n_s_per_m + staged.body.hand.damping_n_s_per_m);
    }

    void addTick(const Simulation& simulation, const TickOutput& out, const BodyState& body, bool resting,
                 bool last_window) {
        TickState now{
            out, body, tissueAt(patient_, out.breath), gain_ * simulation.state().output.safety.level,
            0.0, {}};
        // Without the controller the hand feels the whole force.
        if (simulation.settings().output.controller_share > 0.0) now.stored = simulation.state().stored;
        const NeedleState& needle = simulation.state().tools.needle;
        now.lateral_j = 0.5 * staged_.settings.tools.needle.lateral_stiffness_n_per_m *
                        glm::dot(needle.lateral_m, needle.lateral_m);
        ++result_.ticks;
        result_.faults |= out.faults;
        result_.not_finite = result_.not_finite || !std::isfinite(glm::dot(out.sent_device_n, Vec3(1.0))) ||
                             !std::isfinite(glm::dot(body.position_m, Vec3(1.0)));
        if (has_last_) compare(now);
        if (resting) {
            ++rest_ticks_;
            forced_ticks_ += length(out.sent_device_n) > 1e-3;
        }
        if (last_window) {
            if (track_m_.empty()) fed_before_j_ = fed_j_, lost_before_j_ = body.dissipated_j;
            events_ += out.tool_force.event;
            // Extrapolate the position to the tick's nominal time. Otherwise timing jitter would make a
            // moving body seem to shake.
            const double late_s = body.time_s - double(result_.ticks - 1) / case_.rate_hz;
            const Vec3 at_m = body.position_m - late_s * body.velocity_m_per_s;
            track_m_.push_back(glm::dot(at_m - now.tissue_m, staged_.axis));
        }
        last_ = now;
        has_last_ = true;
    }

    CaseResult result() {
        result_.rise_j = balance_.rise_j();
        // The allowed rise is a bound that does not grow with time: the energy that no controller can
        // observe because of one tick, one encoder count and the delay.
        const double lag_s = case_.delay_s + (1.0 + case_.jitter_s * case_.rate_hz) / case_.rate_hz;
        result_.rise_limit_j = 2.0 * max_n_ * case_.resolution_m +
                               tangent_n_per_m_ * fastest_m_s_ * fastest_m_s_ * lag_s * lag_s + 20e-6;
        result_.forced_share = rest_ticks_ > 0 ? double(forced_ticks_) / double(rest_ticks_) : 0.0;
        result_.cycle =
            findCycle(track_m_, 1.0 / case_.rate_hz, kCycle_m + kCycle_counts * case_.resolution_m);
        const double swing_j = 0.5 * tangent_n_per_m_ * result_.cycle.amplitude_m * result_.cycle.amplitude_m;
        const double fed_j = fed_j_ - fed_before_j_, dissipated_j = last_.body.dissipated_j - lost_before_j_;
        result_.cycle_is_fed = fed_j > dissipated_j && fed_j > kFed_per_s * kCycleWindow_s * swing_j;
        result_.cycle_judged = events_ == 0;
        return result_;
    }

  private:
    double ratio(double damping_n_s_per_m) const {
        return tangent_n_per_m_ / (2.0 * damping_n_s_per_m * case_.rate_hz);
    }
    void compare(const TickState& now) {
        const Vec3 moved_m = now.body.position_m - last_.body.position_m;
        const Vec3 tissue_m = now.tissue_m - last_.tissue_m;
        const double dt_s = 1.0 / case_.rate_hz;
        const Vec3 impulse = now.body.motor_impulse_n_s - last_.body.motor_impulse_n_s;
        const double work_j =
            now.body.motor_work_j - last_.body.motor_work_j - glm::dot(impulse, tissue_m) / dt_s;
        // The model receives the position that the encoder read, not the body's true position.
        const Vec3 read_m = now.out.patient_from_tool.position_m - last_.out.patient_from_tool.position_m;
        const double stored_j =
            last_.scale * storedRise(last_, now, patient_.package().tissues, read_m - tissue_m);
        const Vec3 mean_n =
            0.5 * last_.stored.share() * (last_.out.tool_force.force_n + now.out.tool_force.force_n);
        fed_j_ += work_j - last_.scale * glm::dot(mean_n, read_m - tissue_m);
        balance_.add(work_j, stored_j, now.body.dissipated_j - last_.body.dissipated_j);

        // After an event the force falls over as many ticks as the rate limit requires. Force steps are not
        // judged during these ticks.
        if (now.out.tool_force.event) {
            const double fall_n = length(now.out.tool_force.force_n - last_.out.tool_force.force_n);
            falling_ticks_ = std::max(falling_ticks_,
                                      2 + int(fall_n / (staged_.settings.output.rate_limit_n_per_s * dt_s)));
        }
        if (falling_ticks_ > 0) {
            --falling_ticks_;
        } else {
            const double step_n = length(now.out.sent_device_n - last_.out.sent_device_n);
            const double spring_n = tangent_n_per_m_ * length(read_m - tissue_m);
            result_.step_n = std::max(result_.step_n, step_n - spring_n);
        }
        max_n_ = std::max(max_n_, length(now.out.sent_device_n));
        fastest_m_s_ = std::max(fastest_m_s_, length(moved_m - tissue_m) / dt_s);
    }

    const StressCase& case_;
    const CaseInput& staged_;
    const patient::Patient& patient_;
    double gain_ = 1.0, tangent_n_per_m_ = 0.0;
    CaseResult result_;
    EnergyBalance balance_;
    TickState last_;
    bool has_last_ = false;
    int falling_ticks_ = 0, events_ = 0;
    std::uint64_t rest_ticks_ = 0, forced_ticks_ = 0;
    std::vector<double> track_m_;
    double fed_j_ = 0.0, fed_before_j_ = 0.0, lost_before_j_ = 0.0;
    double max_n_ = 0.0, fastest_m_s_ = 0.0;
};

}  // namespace

CaseResult runCase(const StressCase& c, const Tissues& tissues, bool controller, double seconds) {
    const CaseInput staged = prepareCase(c, tissues, controller);
    Simulation simulation(tissues.at(c.tissues), staged.settings);
    SimulatedDevice device(staged.wanted, staged.profile, staged.body);
    Judge judge(c, staged, tissues, simulation.gain());
    const int ticks = int(seconds * c.rate_hz);
    TickInput input;
    TickOutput out;
    NeedleEvents events;
    for (int i = 0; i < ticks; ++i) {
        const double t_s = double(i) / c.rate_hz;
        input.device = device.read(std::llround(t_s * 1e9));
        const BodyState body = device.body();
        simulation.step(input, out, events);
        device.send(out.sent_device_n);
        judge.addTick(simulation, out, body, t_s >= kRest_s, t_s >= seconds - kCycleWindow_s);
    }
    return judge.result();
}

namespace {

// Returns the force along the needle [N] at each tick of a whole number of breaths.
std::vector<double> recordBreathForces(const StressCase& c, const Tissues& tissues, bool rigid,
                                       bool controller) {
    constexpr double kBreaths_s = 8.0;
    const CaseInput staged = prepareCase(c, tissues, controller);
    Simulation simulation(tissues.at(c.tissues), staged.settings);
    SimulatedDevice yielding(staged.wanted, staged.profile, staged.body);
    ReplayDevice stiff(staged.wanted, 0, staged.profile);
    HapticDevice& device = rigid ? static_cast<HapticDevice&>(stiff) : yielding;
    std::vector<double> forces_n;
    TickInput input;
    TickOutput out;
    NeedleEvents events;
    for (int i = 0; i < int((kRest_s + kBreaths_s) * c.rate_hz); ++i) {
        const double t_s = double(i) / c.rate_hz;
        input.device = device.read(std::llround(t_s * 1e9));
        simulation.step(input, out, events);
        device.send(out.sent_device_n);
        if (t_s >= kRest_s) forces_n.push_back(glm::dot(out.sent_device_n, staged.axis));
    }
    return forces_n;
}

double span(const std::vector<double>& x) {
    const auto [low, high] = std::minmax_element(x.begin(), x.end());
    return *high - *low;
}

}  // namespace

std::vector<StillHand> stillHands(const Tissues& tissues) {
    std::vector<StillHand> hands;
    for (const char* device : {"touch-x", "premium-3.0", "omega.3"}) {
        for (const int rate_hz : {1000, 4000}) {
            for (const bool rigid : {false, true}) {
                StressCase c;
                c.device = findProfile(device);
                c.tissues = Tissues::kLiver;
                c.hand = HandKind::firm;
                c.rate_hz = rate_hz;
                c.delay_s = 0.0005;
                c.resolution_m = 20e-6;
                c.mass_kg = 0.1;
                c.damping_n_s_per_m = 0.02;
                c.breath_amplitude = 1.0;
                c.begin_s = 0.5;
                c.depth_m = 0.030;
                c.speed_m_s = 0.040;
                c.tilt_rad = 0.6;
                StillHand& hand = hands.emplace_back(StillHand{device, rate_hz, rigid});
                const std::vector<double> on = recordBreathForces(c, tissues, rigid, true),
                                          off = recordBreathForces(c, tissues, rigid, false);
                hand.on_n = span(on);
                hand.off_n = span(off);
                for (std::size_t i = 0; i < on.size(); ++i)
                    hand.apart_n = std::max(hand.apart_n, std::fabs(on[i] - off[i]));
            }
        }
    }
    return hands;
}

}  // namespace stylet::stress
