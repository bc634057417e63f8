#include "xr/state_machine.h"

#include <gtest/gtest.h>

namespace stylet::xr {
namespace {

TEST(StateMachine, BeginsOnReadyAndEndsOnStopping) {
    StateMachine machine;
    EXPECT_EQ(machine.onState(XR_SESSION_STATE_IDLE), SessionCall::none);
    EXPECT_FALSE(machine.running);
    EXPECT_EQ(machine.onState(XR_SESSION_STATE_READY), SessionCall::begin);
    EXPECT_TRUE(machine.running);
    for (const XrSessionState state :
         {XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_FOCUSED}) {
        EXPECT_EQ(machine.onState(state), SessionCall::none);
        EXPECT_TRUE(machine.running);
    }
    EXPECT_EQ(machine.phase, SessionPhase::focused);
    EXPECT_EQ(machine.onState(XR_SESSION_STATE_STOPPING), SessionCall::end);
    EXPECT_FALSE(machine.running);
    EXPECT_FALSE(machine.isFinal());
}

TEST(StateMachine, ASessionMayBeginAgain) {
    StateMachine machine;
    machine.onState(XR_SESSION_STATE_READY);
    machine.onState(XR_SESSION_STATE_STOPPING);
    machine.onState(XR_SESSION_STATE_IDLE);
    EXPECT_EQ(machine.phase, SessionPhase::idle);
    EXPECT_EQ(machine.onState(XR_SESSION_STATE_READY), SessionCall::begin);
    EXPECT_TRUE(machine.running);
}

TEST(StateMachine, ARepeatedStateRequiresNoCall) {
    StateMachine machine;
    machine.onState(XR_SESSION_STATE_READY);
    EXPECT_EQ(machine.onState(XR_SESSION_STATE_READY), SessionCall::none);
    machine.onState(XR_SESSION_STATE_STOPPING);
    EXPECT_EQ(machine.onState(XR_SESSION_STATE_STOPPING), SessionCall::none);
}

TEST(StateMachine, ExitingAndLossAreFinal) {
    for (const XrSessionState last : {XR_SESSION_STATE_EXITING, XR_SESSION_STATE_LOSS_PENDING}) {
        StateMachine machine;
        machine.onState(XR_SESSION_STATE_READY);
        machine.onState(XR_SESSION_STATE_FOCUSED);
        EXPECT_EQ(machine.onState(last), SessionCall::none);
        EXPECT_FALSE(machine.running);
        EXPECT_TRUE(machine.isFinal());
        const SessionPhase phase = machine.phase;
        EXPECT_EQ(machine.onState(XR_SESSION_STATE_READY), SessionCall::none);
        EXPECT_EQ(machine.phase, phase);
        EXPECT_FALSE(machine.running);
    }
}

}  // namespace
}  // namespace stylet::xr
