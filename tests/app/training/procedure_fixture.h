// Fixture: a procedure on the wall of wall.h, to which the tests pass hand-made ticks. No simulation runs.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>

#include "app/trainer/attempt/tool_pose.h"
#include "app/training/attempt_fold.h"
#include "app/training/procedure.h"
#include "tests/app/training/wall.h"
#include "tests/support/constants.h"

namespace stylet::training {

class ProcedureTest : public testing::Test {
  protected:
    using TickOutput = haptics::TickOutput;
    using Tool = haptics::Tool;
    using Tissue = patient::Tissue;

    explicit ProcedureTest(patient::Package package = test::wallWithVessel())
        : package_(std::move(package)) {}

    void update(TickOutput out, int times = 1) {
        for (int n = 0; n < times; ++n) {
            out.tick = tick_++;
            procedure_.update(out, fold_);
        }
    }
    TickOutput needleAt(const Vec3& tip_m, Tissue tissue, std::uint8_t label) const {
        TickOutput out;
        out.patient_from_tool = out.patient_from_needle = trainer::needlePose(tip_m, {1, 0, 0});
        out.tip_reference_m = tip_m;
        out.phase = tip_m.x > 0.0 ? haptics::Phase::pass : haptics::Phase::outside;
        out.depth_m = tip_m.x, out.tissue = tissue, out.label = label;
        return out;
    }
    TickOutput vessel() const { return needleAt({0.033, 0, 0}, Tissue::vessel, test::kVesselLabel); }
    TickOutput liver(double x_m, double y_m = 0.0) const {
        return needleAt({x_m, y_m, 0.0}, Tissue::liver, test::kLiverLabel);
    }
    static TickOutput finger(const Vec3& at_m, double force_n) {
        TickOutput out;
        out.tool = Tool::finger;
        out.patient_from_tool = trainer::needlePose(at_m, {1, 0, 0});
        out.tool_force.force_n = {-force_n, 0.0, 0.0};
        return out;
    }
    static TickOutput probeAt(const Vec3& face_m, const Vec3& into) {
        TickOutput out;
        out.tool = Tool::probe;
        out.probe_touching_share = 1.0;
        out.patient_from_tool = trainer::needlePose(face_m, into);
        return out;
    }
    static TickOutput parked(TickOutput probe) {
        probe.probe_parked = true;
        probe.patient_from_probe = probe.patient_from_tool * haptics::kStylusFromProbe;
        return probe;
    }
    bool done(Step step) const { return (procedure_.progress().steps_done & 1u << unsigned(step)) != 0; }
    double value(MetricId id) const { return procedure_.score().values[std::size_t(id)]; }
    const Progress& progress() const { return procedure_.progress(); }

    patient::Package package_;
    patient::Patient patient_{package_};
    AttemptFold fold_{patient_, test::kDt_s};
    Procedure procedure_{patient_, test::wallPath(), test::kDt_s};
    std::uint64_t tick_ = 1;
};

}  // namespace stylet::training
