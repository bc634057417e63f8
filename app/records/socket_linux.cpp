#include "app/records/socket_linux.h"

#include <sys/socket.h>

namespace stylet::records {

void shutdownSocket(int socket) noexcept {
    shutdown(socket, SHUT_RDWR);
}

}  // namespace stylet::records
