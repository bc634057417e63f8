// Ends a connection from another thread.
#pragma once

namespace stylet::records {

// Wakes any thread that waits on the socket, with an error. Does not close the socket.
void shutdownSocket(int socket) noexcept;

}  // namespace stylet::records
