// ALSA, where it is installed, prints a dozen lines about a device that is not there.
#pragma once

namespace stylet::trainer {

// From now on it says nothing: what matters is said in our own words.
void quietAlsa();

}  // namespace stylet::trainer
