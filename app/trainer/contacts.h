// What the tools of a tick press on and drag along, as the picture shows it. Nothing here reaches a force.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "haptics/haptics.h"
#include "patient/tool_displacement.h"

namespace stylet::trainer {

struct ToolContacts {
    int count = 0;
    std::array<patient::ToolContact, patient::kMaxContacts> list{};
    std::span<const patient::ToolContact> all() const { return {list.data(), std::size_t(count)}; }
};

// The needle's tip is where its proxy's tissue has been taken, and drags the tissue along its shaft; finger,
// probe and scalpel take the skin along. Without a map of the skin only needle and scalpel press.
ToolContacts contactsOf(const haptics::TickOutput&, const patient::Patient&, const haptics::TouchMap*);

// A tick's tools as the picture's displacement, from one shown tick to the next. Frame thread.
class ToolPress {
  public:
    // Both must outlive it; `tick_s` is the loop's.
    ToolPress(const patient::Patient&, const haptics::TouchMap*, double tick_s);

    // Null: nothing presses. Else until the next call.
    const patient::DisplacementTable* shown(const haptics::TickOutput&);

  private:
    const patient::Patient* patient_;
    const haptics::TouchMap* touch_;
    double tick_s_;
    patient::ToolDisplacement displacement_;
    std::optional<std::uint64_t> tick_;
};

}  // namespace stylet::trainer
