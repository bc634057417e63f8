// Recomputes a record: the same inputs through the same step function must give the same state hash.
#pragma once

#include <functional>
#include <optional>

#include "app/records/record.h"

namespace stylet::records {

struct ReplayResult {
    std::uint64_t ticks = 0;
    std::uint64_t state_hash = 0;
    // The first frame whose recorded hash differs. The difference arose in the ticks of that frame.
    std::optional<Checkpoint> first_mismatch;
    // record.json lists a last tick that was not reached, or another state hash at the end.
    bool end_mismatch = false;
    bool equal() const { return !first_mismatch && !end_mismatch; }
};

using TickCallback =
    std::function<void(const haptics::TickInput&, const haptics::TickOutput&, const haptics::NeedleEvents&)>;

// Returns haptics::makeTouchMap(patient), or the same from a cache.
using MakeTouch = std::function<haptics::TouchMap(const patient::Patient&)>;

// Throws DataError if the record was made with another patient. `each` may be empty. An empty `make_touch`
// computes the map.
ReplayResult replay(const patient::Patient&, const Record&, const TickCallback& each,
                    const MakeTouch& make_touch = {});

}  // namespace stylet::records
