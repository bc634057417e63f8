#include "haptics/devices/woodenhaptics/woodenhaptics_model.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "base/whole_file.h"
#include "patient/patient.h"

namespace stylet::haptics {

using Json = nlohmann::json;

namespace {

constexpr std::size_t kMaxModelBytes = 64 << 10;
constexpr std::size_t kMaxName = 100;
constexpr int kMaxDepth = 2;
constexpr int kUnpublishedVariant = 3;

// Reads the document's members; finish() rejects any member that was not read.
class ModelReader {
  public:
    ModelReader(std::string_view text, const std::filesystem::path& file) : file_(file) {
        std::set<std::string> keys;
        const auto watch = [&](int depth, Json::parse_event_t event, Json& parsed) {
            if (depth > kMaxDepth) throw DataError(file_, "json", "nested too deeply");
            if (event == Json::parse_event_t::key && !keys.insert(parsed.get<std::string>()).second)
                refuseTwice(parsed.get<std::string>());
            return true;
        };
        try {
            json_ = Json::parse(text, watch);
        } catch (const Json::exception& e) {
            throw DataError(file_, "json", e.what());
        }
        if (!json_.is_object()) throw DataError(file_, "json", "not an object");
    }

    double number(const std::string& key, double low, double high) {
        const Json& value = member(key);
        if (!value.is_number()) throw DataError(file_, key, "not a number");
        const double v = value.get<double>();
        if (!(v >= low && v <= high))
            throw DataError(file_, key, "not within " + textOf(low) + " and " + textOf(high));
        return v;
    }
    int whole(const std::string& key, int low, int high) {
        const double v = number(key, low, high);
        if (v != std::floor(v)) throw DataError(file_, key, "not a whole number");
        return int(v);
    }
    // The library writes true and false; its tables use 1 and 0.
    bool flag(const std::string& key) {
        const Json& value = member(key);
        if (value.is_boolean()) return value.get<bool>();
        if (value.is_number() && (value == 0 || value == 1)) return value == 1;
        throw DataError(file_, key, "neither true nor false");
    }
    std::string text(const std::string& key, std::string otherwise) {
        if (!json_.contains(key)) return otherwise;
        const Json& value = member(key);
        if (!value.is_string() || value.get<std::string>().size() > kMaxName)
            throw DataError(file_, key, "not a text of at most " + std::to_string(kMaxName) + " bytes");
        return value.get<std::string>();
    }
    template <std::size_t kCount>
    std::array<double, kCount> numbers(const std::string& stem, const char* bodies, double low, double high) {
        std::array<double, kCount> values{};
        for (std::size_t i = 0; i < kCount; ++i)
            values[i] = number(stem + bodies[i], low, high);
        return values;
    }
    std::array<bool, 3> flags(const std::string& stem, const char* bodies) {
        return {flag(stem + bodies[0]), flag(stem + bodies[1]), flag(stem + bodies[2])};
    }
    [[noreturn]] void refuse(const std::string& key, const std::string& reason) const {
        throw DataError(file_, key, reason);
    }
    void finish() const {
        for (const auto& [key, value] : json_.items())
            if (!taken_.contains(key)) throw DataError(file_, key, "unknown key");
    }

  private:
    static std::string textOf(double v) { return Json(v).dump(); }
    [[noreturn]] void refuseTwice(const std::string& key) const {
        throw DataError(file_, key,
                        key == "enc_and_body_aligned_d"
                            ? "given twice: the maker's library writes enc_and_body_aligned_e so; rename the "
                              "second one"
                            : "given twice");
    }
    const Json& member(const std::string& key) {
        const auto found = json_.find(key);
        if (found == json_.end()) throw DataError(file_, key, "missing");
        taken_.insert(key);
        return *found;
    }

    const std::filesystem::path& file_;
    Json json_;
    std::set<std::string> taken_;
};

void readEncoders(ModelReader& in, WoodenModel& m) {
    const auto arm = in.numbers<3>("cpr_encoder_", "abc", 16.0, 1e6);
    const auto wrist = in.numbers<3>("cpr_encoder_", "def", 0.0, 1e6);
    const auto fitted = std::count_if(wrist.begin(), wrist.end(), [](double n) { return n > 0.0; });
    if (fitted != 0 && fitted != 3)
        in.refuse("cpr_encoder_d",
                  "a wrist has three encoders or none; this one has " + std::to_string(fitted));
    for (std::size_t i = 0; i < 3; ++i) {
        if (fitted == 3 && wrist[i] < 16.0)
            in.refuse(std::string("cpr_encoder_") + "def"[i], "not within 16 and 1000000");
        m.counts_per_turn[i] = arm[i];
        m.counts_per_turn[3 + i] = wrist[i];
    }
    for (std::size_t i = 0; i < 6; ++i)
        m.calibration_counts[i] =
            std::int16_t(in.whole(std::string("calibrate_enc_") + "abcdef"[i], INT16_MIN, INT16_MAX));
    m.motor_aligned = in.flags("motor_and_body_aligned_", "abc");
    m.wrist_aligned = in.flags("enc_and_body_aligned_", "def");
}

}  // namespace

WoodenModel parseWoodenModel(std::string_view text, const std::filesystem::path& file) {
    ModelReader in(text, file);
    WoodenModel m;
    m.name = in.text("name", m.name);
    if (in.whole("variant", 0, kUnpublishedVariant) == kUnpublishedVariant)
        in.refuse("variant", "3 (Polhem v2 and v3): its kinematics are not public, so it cannot be driven");
    m.capstan_diameter_m = in.numbers<3>("diameter_capstan_", "abc", 0.001, 1.0);
    m.body_diameter_m = in.numbers<3>("diameter_body_", "abc", 0.001, 1.0);
    m.length_m = in.numbers<3>("length_body_", "abc", 0.01, 1.0);
    m.workspace_origin_m = {in.number("workspace_origin_x", -1.0, 1.0),
                            in.number("workspace_origin_y", -1.0, 1.0),
                            in.number("workspace_origin_z", -1.0, 1.0)};
    m.workspace_radius_m = in.number("workspace_radius", 0.01, 1.0);
    m.torque_constant_n_m_per_a = in.numbers<3>("torque_constant_motor_", "abc", 0.001, 10.0);
    in.number("current_for_10_v_signal", 0.0, 100.0);  // for analogue amplifiers only
    readEncoders(in, m);
    m.force_peak_n = in.number("max_linear_force", 0.1, 50.0);
    m.stiffness_n_per_m = in.number("max_linear_stiffness", 1.0, 20000.0);
    in.number("max_linear_damping", 0.0, 1000.0);  // rendered, not physical
    m.mass_kg = in.numbers<2>("mass_body_", "bc", 0.0, 5.0);
    m.centre_of_mass_m = in.numbers<2>("length_cm_body_", "bc", -1.0, 1.0);
    m.gravity_m_s2 = in.number("g_constant", -20.0, 20.0);
    in.finish();
    return m;
}

WoodenModel loadWoodenModel(const std::filesystem::path& json) {
    return parseWoodenModel(readWholeFile(json, kMaxModelBytes), json);
}

}  // namespace stylet::haptics
