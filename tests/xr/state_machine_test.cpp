#include "xr/state_machine.h"

#include <gtest/gtest.h>

namespace stylet::xr {
namespace {

TEST(StateMachine, BeginsOnReadyAndEndsOnStopping) {
    StateMachine machine;
    EXPECT_EQ(machine.onState(XR_SESSION_STATE_IDLE), SessionAct::none);
    EXPECT_FALSE(machine.running);
    EXPECT_EQ(machine.onState(XR_SESSION_STATE_READY), SessionAct::begin);
    EXPECT_TRUE(machine.running);
    for (const XrSessionState state :
         {XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_FOCUSED}) {
        EXPECT_EQ(machine.onState(state), SessionAct::none);
        EXPECT_TRUE(machine.running);
    }
    EXPECT_EQ(machine.phase, SessionPhase::focused);
    EXPECT_EQ(machine.onState(XR_SESSION_STATE_STOPPING), SessionAct::end);
    EXPECT_FALSE(machine.running);
    EXPECT_FALSE(machine.over());
}

TEST(StateMachine, ASessionMayBeginAgain) {
    StateMachine machine;
    machine.onState(XR_SESSION_STATE_READY);
    machine.onState(XR_SESSION_STATE_STOPPING);
    machine.onState(XR_SESSION_STATE_IDLE);
    EXPECT_EQ(machine.phase, SessionPhase::idle);
    EXPECT_EQ(machine.onState(XR_SESSION_STATE_READY), SessionAct::begin);
    EXPECT_TRUE(machine.running);
}

TEST(StateMachine, ARepeatedStateAsksForNothing) {
    StateMachine machine;
    machine.onState(XR_SESSION_STATE_READY);
    EXPECT_EQ(machine.onState(XR_SESSION_STATE_READY), SessionAct::none);
    machine.onState(XR_SESSION_STATE_STOPPING);
    EXPECT_EQ(machine.onState(XR_SESSION_STATE_STOPPING), SessionAct::none);
}

TEST(StateMachine, ExitingAndLossAreFinal) {
    for (const XrSessionState last : {XR_SESSION_STATE_EXITING, XR_SESSION_STATE_LOSS_PENDING}) {
        StateMachine machine;
        machine.onState(XR_SESSION_STATE_READY);
        machine.onState(XR_SESSION_STATE_FOCUSED);
        EXPECT_EQ(machine.onState(last), SessionAct::none);
        EXPECT_FALSE(machine.running);
        EXPECT_TRUE(machine.over());
        const SessionPhase phase = machine.phase;
        EXPECT_EQ(machine.onState(XR_SESSION_STATE_READY), SessionAct::none);
        EXPECT_EQ(machine.phase, phase);
        EXPECT_FALSE(machine.running);
    }
}

}  // namespace
}  // namespace stylet::xr
