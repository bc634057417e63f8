// Sends the reports of an old or a recent SpaceMouse. Formats from FreeSpacenav/spacenavd and
// andunhh.github.io/spacemouse.
#pragma once

#include <array>

#include "tests/support/hid_testbed.h"

namespace stylet::test {

class SpaceMouseEmulator {
  public:
    enum class Age { old, recent };  // translation and rotation in separate reports, or in one
    explicit SpaceMouseEmulator(Age);

    // Reports the displacement of the cap. Returns false if the driver does not read it. A recent device also
    // reports the rotation; an old one needs turn() for it.
    bool push(const std::array<int, 6>& axes);
    bool turn(const std::array<int, 6>& axes);
    bool press(unsigned mask);
    bool garble(std::span<const unsigned char> report) { return node_.send(report); }
    void unplug() { node_.unplug(); }
    const std::string& path() const { return node_.path(); }

  private:
    Age age_;
    HidNode node_;
};

}  // namespace stylet::test
