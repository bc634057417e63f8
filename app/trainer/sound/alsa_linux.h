// Silences ALSA, which prints a dozen lines about a missing device.
#pragma once

namespace stylet::trainer {

// Installs an empty error handler in ALSA, if it is installed. Relevant errors are reported in our own
// words.
void quietAlsa();

}  // namespace stylet::trainer
