// The program of a bridge, which connects a vendor's SDK to the trainer: socket, clock, main().
#pragma once

#include <atomic>
#include <string>

#include "haptics/devices/bridge/server.h"

namespace stylet::haptics::bridge {

// CLOCK_MONOTONIC, for Sample::sampled_ns.
std::int64_t monotonic_ns() noexcept;

// Interface to a vendor's SDK.
class Sdk {
  public:
    virtual ~Sdk() = default;
    // Finds the device and fills in its capabilities.
    virtual bool open(Capabilities&, std::string& why) = 0;
    // Starts the SDK's servo thread, which calls servo.tick() and applies the returned force until stop().
    virtual bool start(Servo&, std::string& why) = 0;
    // Sends zero force, then releases the device. Called on every exit.
    virtual void stop() noexcept = 0;
};

// Opens the SDK and serves one trainer process after another until `stop` or until the device is lost.
// Returns the reason if it failed, else an empty string.
std::string serve(Sdk&, const std::string& socket_path, const std::atomic<bool>& stop);

// main() of a bridge: NAME [--socket PATH]. Runs until SIGINT, SIGTERM or SIGHUP.
int bridgeMain(Sdk&, int argc, char** argv);

}  // namespace stylet::haptics::bridge
