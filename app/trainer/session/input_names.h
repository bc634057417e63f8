// Names of the inputs that are no person's: `--device` and RecordInfo::device.
#pragma once

namespace stylet::trainer {

inline constexpr const char* kScriptedDevice = "scripted";  // the scenario's script
inline constexpr const char* kReplayDevice = "replay";      // a trace file

}  // namespace stylet::trainer
