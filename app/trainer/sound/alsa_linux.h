// Silences ALSA, which otherwise prints a dozen lines if a device is missing.
#pragma once

namespace stylet::trainer {

// Installs an empty error handler, if ALSA is installed. The trainer reports the relevant errors itself.
void quietAlsa();

}  // namespace stylet::trainer
