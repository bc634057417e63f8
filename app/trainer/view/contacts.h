// Contacts of the tools with the tissue in one tick, for rendering only. They never affect a force.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "haptics/haptics.h"
#include "patient/displacement/tool_displacement.h"

namespace stylet::trainer {

struct ToolContacts {
    int count = 0;
    std::array<patient::ToolContact, patient::kMaxContacts> list{};
    std::span<const patient::ToolContact> all() const { return {list.data(), std::size_t(count)}; }
};

// Data of an attempt from which the contacts follow.
struct PressInput {
    const haptics::TouchMap* touch = nullptr;  // skin that finger and probe press
    haptics::ToolSettings tools{};
    double tick_s = 0.001;  // the loop's tick period
};

// Finds the contacts. The needle drags the tissue along its shaft: the tissue at the proxy moves to the tip.
// Finger, probe and scalpel displace the skin. Without a touch map, only needle and scalpel have contacts.
ToolContacts findContacts(const haptics::TickOutput&, const patient::Patient&, const PressInput&);

// Computes the tissue displacement by tools that a picture shows, from one shown tick to the next. Frame
// thread.
class ToolPress {
  public:
    // Patient and touch map must outlive this object.
    ToolPress(const patient::Patient&, const PressInput&);

    // Returns null if nothing is displaced. Otherwise the table is valid until the next call.
    const patient::DisplacementTable* shown(const haptics::TickOutput&);

  private:
    const patient::Patient* patient_;
    PressInput input_;
    patient::ToolDisplacement displacement_;
    std::optional<std::uint64_t> tick_;
};

}  // namespace stylet::trainer
