// A needle in front of a column of layers, ready to be pushed in.
#pragma once

#include <gtest/gtest.h>

#include "tests/haptics/column.h"

namespace stylet::test {

// Starts the needle 5 mm before the first border.
struct Puncture {
    explicit Puncture(const Layers& layers, double pitch_m = 0.0001)
        : package(makeColumn(layers, pitch_m)), patient(package), hand(patient) {
        hand.to(-0.005);
    }
    const haptics::NeedleEvent& last() const { return hand.events.back(); }
    haptics::NeedleEvent only(haptics::NeedleEventKind kind, patient::Tissue into) const {
        std::vector<haptics::NeedleEvent> found;
        for (const haptics::NeedleEvent& e : hand.eventsOf(kind)) {
            if (e.border.to == into) found.push_back(e);
        }
        EXPECT_EQ(found.size(), 1u) << "into " << patient::tissueName(into);
        return found.empty() ? haptics::NeedleEvent{} : found.front();
    }
    void expectCut(patient::Tissue into, double behind_m, double before_n, double after_n) const {
        const haptics::NeedleEvent cut = only(haptics::NeedleEventKind::puncture, into);
        EXPECT_NEAR(cut.tenting_m, behind_m, 1e-9);
        EXPECT_NEAR(cut.force_before_n, before_n, 1e-9);
        EXPECT_NEAR(cut.force_after_n, after_n, 1e-9);
        EXPECT_EQ(cut.role, patient.row(into).role);
    }
    patient::Package package;
    patient::Patient patient;
    Hand hand;
};

inline const Layers kTorso{{patient::Tissue::skin, 0.002},   {patient::Tissue::soft, 0.02},
                           {patient::Tissue::fascia, 0.003}, {patient::Tissue::liver, 0.03},
                           {patient::Tissue::duct, 0.004},   {patient::Tissue::liver, 0.02}};

}  // namespace stylet::test
