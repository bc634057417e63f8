// A bridge as a program: its socket, its clock, its main().
#pragma once

#include <atomic>
#include <string>

#include "haptics/devices/bridge/server.h"

namespace stylet::haptics::bridge {

// CLOCK_MONOTONIC, for Sample::sampled_ns.
std::int64_t monotonic_ns() noexcept;

// What a vendor's SDK is made to do.
class Sdk {
  public:
    virtual ~Sdk() = default;
    // Finds the device, fills in what it can do.
    virtual bool open(Capabilities&, std::string& why) = 0;
    // Its servo thread calls servo.tick() and applies what that returns, until stop().
    virtual bool start(Servo&, std::string& why) = 0;
    // Zero force, then lets go. On every way out.
    virtual void stop() noexcept = 0;
};

// Opens the SDK and serves one Stylet after the other until `stop`, or until the device is lost: then the
// reason is returned, and an empty text otherwise.
std::string serve(Sdk&, const std::string& socket_path, const std::atomic<bool>& stop);

// main() of a bridge: NAME [--socket PATH], until SIGINT, SIGTERM or SIGHUP.
int bridgeMain(Sdk&, int argc, char** argv);

}  // namespace stylet::haptics::bridge
