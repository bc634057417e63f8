// A SpaceMouse's reports, of either age. Facts from FreeSpacenav/spacenavd and andunhh.github.io/spacemouse.
#pragma once

#include <array>

#include "tests/support/hid_testbed.h"

namespace stylet::test {

class SpaceMouseEmulator {
  public:
    enum class Age { old, recent };  // translation and rotation apart, or together
    // `read_here`: as of HidNode.
    explicit SpaceMouseEmulator(Age, bool read_here = false);

    // The cap pushed that far; false when the driver does not take it. An old one then has to tell of its
    // turn, a recent one has told.
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
