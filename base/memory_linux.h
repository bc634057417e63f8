// Memory of programs that make and free large volumes all the time.
#pragma once

namespace stylet {

// Keeps freed memory in the program, in huge pages where the system has them. Otherwise each new volume costs
// the time in which the system clears its pages. Call it once, before any thread is started.
void keepFreedMemory();

}  // namespace stylet
