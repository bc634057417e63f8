// A connection ended from another thread.
#pragma once

namespace stylet::records {

// Who waits on the socket is woken with an error; its owner closes it.
void shutDown(int socket) noexcept;

}  // namespace stylet::records
