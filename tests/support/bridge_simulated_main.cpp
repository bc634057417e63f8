// stylet-bridge-simulated [--socket PATH]: runs the reference bridge with the simulated SDK.
#include "tests/support/bridge_simulated.h"

int main(int argc, char** argv) {
    stylet::test::SimulatedSdk sdk;
    return stylet::haptics::bridge::bridgeMain(sdk, argc, argv);
}
