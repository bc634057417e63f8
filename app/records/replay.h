// Recomputation of a record: the same inputs through the same step must end in the same hash.
#pragma once

#include <functional>
#include <optional>

#include "app/records/record.h"

namespace stylet::records {

struct ReplayResult {
    std::uint64_t ticks = 0;
    std::uint64_t state_hash = 0;
    // The first frame whose recorded hash was not met; the difference arose in the ticks before it.
    std::optional<Checkpoint> differs_at;
    // record.json names an end that was not reached or not met.
    bool end_missed = false;
    bool equal() const { return !differs_at && !end_missed; }
};

using EachTick =
    std::function<void(const haptics::TickInput&, const haptics::TickOutput&, const haptics::NeedleEvents&)>;

// Throws DataError when the record was made on another patient. `each` may be empty.
ReplayResult replay(const patient::Patient&, const Record&, const EachTick& each);

}  // namespace stylet::records
