#include "app/records/result.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/fields.h"

namespace stylet::records {

using nlohmann::ordered_json;

namespace {

constexpr std::size_t kMaxRows = 1 << 20;  // of a list
constexpr const char *kInfinite = "inf", *kMinusInfinite = "-inf";

// Writes the fields that visit...() names into a JSON object.
struct Writer {
    ordered_json& out;

    void number(const char* key, double v) const {
        out[key] = std::isnan(v)   ? ordered_json(nullptr)
                   : std::isinf(v) ? ordered_json(v > 0.0 ? kInfinite : kMinusInfinite)
                                   : ordered_json(v);
    }
    void count(const char* key, std::uint64_t v) const { out[key] = v; }
    void flag(const char* key, bool v) const { out[key] = v; }
    void text(const char* key, const std::string& v) const { out[key] = v; }
    void texts(const char* key, const std::vector<std::string>& v) const { out[key] = v; }
    // Fields that older records lack: `v` then keeps its default.
    void newFlag(const char* key, bool v) const { flag(key, v); }
    void newCount(const char* key, std::uint64_t v) const { count(key, v); }
    void newNumber(const char* key, double v) const { number(key, v); }
    template <typename Visit>
    void object(const char* key, const Visit& visit) const {
        visit(Writer{out[key] = ordered_json::object()});
    }
    template <typename Value, typename Visit>
    void optional(const char* key, const std::optional<Value>& v, const Visit& visit) const {
        if (v) object(key, [&](const Writer& inner) { visit(inner, *v); });
    }
    template <typename Row, typename Visit>
    void rows(const char* key, const std::vector<Row>& all, const Visit& visit) const {
        ordered_json& list = out[key] = ordered_json::array();
        for (const Row& row : all)
            visit(Writer{list.emplace_back(ordered_json::object())}, row);
    }
};

// Reads the same fields from a file.
struct Reader {
    Fields& in;

    void number(const char* key, double& v) const {
        const FieldKind kind = in.kind(key);
        if (kind == FieldKind::null) {
            in.ignore(key);
            v = std::numeric_limits<double>::quiet_NaN();
        } else if (kind == FieldKind::text) {
            const std::string name = in.text(key);
            if (name != kInfinite && name != kMinusInfinite) in.refuse(key, "is no number");
            v = name == kInfinite ? INFINITY : -INFINITY;
        } else {
            v = in.number(key);
        }
    }
    void count(const char* key, std::uint64_t& v) const { v = in.count(key); }
    void flag(const char* key, bool& v) const { v = in.flag(key); }
    void text(const char* key, std::string& v) const { v = in.text(key); }
    void texts(const char* key, std::vector<std::string>& v) const { v = in.texts(key, kMaxRows); }
    void newFlag(const char* key, bool& v) const {
        if (in.has(key)) flag(key, v);
    }
    void newNumber(const char* key, double& v) const {
        if (in.has(key)) number(key, v);
    }
    void newCount(const char* key, std::uint64_t& v) const {
        if (in.has(key)) count(key, v);
    }
    template <typename Visit>
    void object(const char* key, const Visit& visit) const {
        Fields inner = in.child(key);
        visit(Reader{inner});
        inner.finish();
    }
    template <typename Value, typename Visit>
    void optional(const char* key, std::optional<Value>& v, const Visit& visit) const {
        if (in.has(key)) object(key, [&](const Reader& inner) { visit(inner, v.emplace()); });
    }
    template <typename Row, typename Visit>
    void rows(const char* key, std::vector<Row>& all, const Visit& visit) const {
        for (Fields& inner : in.children(key, kMaxRows)) {
            visit(Reader{inner}, all.emplace_back());
            inner.finish();
        }
    }
};

// Each visit...() names the fields of one type once, for writing and reading.

void visitScore(const auto& v, auto& r) {
    v.newCount("version", r.score_version);
    v.number("total", r.total);
    v.rows("metrics", r.metrics, [](const auto& row, auto& m) {
        row.text("id", m.id), row.text("name", m.name), row.text("unit", m.unit);
        row.number("value", m.value), row.number("points", m.points);
        row.number("most_points", m.max_points);
    });
}

void visitPuncture(const auto& v, auto& p) {
    v.text("tissue", p.tissue), v.text("kind", p.kind), v.text("label", p.label);
    v.number("border_depth_m", p.border_depth_m), v.number("tenting_m", p.tenting_m);
    v.number("force_before_n", p.force_before_n), v.number("force_after_n", p.force_after_n);
    v.count("tick", p.tick);
}

void visitDose(const auto& v, auto& d) {
    v.number("fluoroscopy_s", d.fluoroscopy_s), v.count("pulses", d.pulses);
    v.number("air_kerma_gy", d.air_kerma_gy), v.number("dose_area_gy_m2", d.dose_area_gy_m2);
    v.number("contrast_ml", d.contrast_ml), v.newNumber("anaesthetic_ml", d.anaesthetic_ml);
}

void visitContrast(const auto& v, auto& c) {
    v.text("last_place", c.last_place);
    v.number("ducts_ml", c.ducts_ml), v.number("liver_ml", c.liver_ml);
    v.number("vessels_ml", c.vessels_ml), v.number("pooled_ml", c.pooled_ml);
    v.number("washed_out_ml", c.washed_out_ml), v.number("lost_ml", c.lost_ml);
    v.number("duct_tree_ml", c.duct_tree_ml), v.number("front_m", c.front_m);
    v.flag("at_stop", c.at_stop);
}

void visitForceError(const auto& v, auto& e) {
    v.count("ticks", e.ticks), v.number("equal_share", e.equal_share), v.number("rms_n", e.rms_n);
    v.number("largest_n", e.largest_n), v.number("largest_depth_m", e.largest_depth_m);
}

void visitForceTruth(const auto& v, auto& t) {
    v.text("felt", t.felt), v.count("insertions", t.insertions);
    v.object("last_insertion", [&](const auto& inner) { visitForceError(inner, t.last_insertion); });
    v.object("all_insertions", [&](const auto& inner) { visitForceError(inner, t.all_insertions); });
}

void visitHaptics(const auto& v, auto& h) {
    v.count("ticks", h.ticks), v.number("rate_hz", h.rate_hz), v.count("late_ticks", h.late_ticks);
    v.count("page_faults", h.page_faults), v.count("faults", h.faults), v.text("fault_names", h.fault_names);
    v.count("flights", h.flights), v.count("flights_lost", h.flights_lost);
    v.object("controller", [&](const auto& inner) {
        inner.count("contact_ticks", h.contact_ticks), inner.number("felt_share", h.felt_share);
        inner.number("peak_n", h.peak_n), inner.number("rms_n", h.rms_n);
    });
    v.number("max_step_us", h.max_step_us);
}

void visitResult(const auto& v, auto& r) {
    v.flag("target_hit", r.target_hit), v.newFlag("aborted", r.aborted), v.count("ticks", r.ticks);
    v.object("score", [&](const auto& inner) { visitScore(inner, r); });
    v.object("steps", [&](const auto& inner) {
        inner.text("goal", r.steps.goal);
        inner.texts("done", r.steps.done), inner.count("of", r.steps.of);
        inner.count("out_of_order", r.steps.out_of_order);
    });
    v.rows("moments", r.captures, [](const auto& row, auto& c) {
        row.text("name", c.name), row.count("tick", c.tick), row.number("depth_m", c.depth_m);
    });
    v.rows("punctures", r.punctures, [](const auto& row, auto& p) { visitPuncture(row, p); });
    v.number("peak_force_n", r.peak_force_n), v.number("lateral_cut_m", r.lateral_cut_m);
    v.optional("force_truth", r.force_truth, [](const auto& inner, auto& t) { visitForceTruth(inner, t); });
    v.object("dose", [&](const auto& inner) { visitDose(inner, r.dose); });
    v.object("contrast", [&](const auto& inner) { visitContrast(inner, r.contrast); });
    v.object("haptics", [&](const auto& inner) { visitHaptics(inner, r.haptics); });
}

void visitEvent(const auto& v, auto& event) {
    v.count("tick", event.tick), v.text("kind", event.kind), v.text("text", event.text);
}

}  // namespace

ordered_json resultJson(const AttemptResult& result) {
    ordered_json out = ordered_json::object();
    visitResult(Writer{out}, result);
    return out;
}

ordered_json eventsJson(const std::vector<EventRow>& events) {
    ordered_json out = ordered_json::object();
    Writer{out}.rows("events", events, [](const auto& row, auto& event) { visitEvent(row, event); });
    return out["events"];
}

AttemptResult parseResult(Fields in) {
    AttemptResult result;
    visitResult(Reader{in}, result);
    in.finish();
    return result;
}

std::vector<EventRow> parseEvents(Fields& in, const char* key) {
    std::vector<EventRow> events;
    Reader{in}.rows(key, events, [](const auto& row, auto& event) { visitEvent(row, event); });
    return events;
}

}  // namespace stylet::records
