// Marks what the 1 kHz thread calls: under clang's RealtimeSanitizer an allocation, a lock or a system call
// in such a function ends the program. Other compilers see nothing.
#pragma once

#if defined(__clang__) && defined(__has_cpp_attribute)
#if __has_cpp_attribute(clang::nonblocking)
#define STYLET_NONBLOCKING [[clang::nonblocking]]
#endif
#endif
#ifndef STYLET_NONBLOCKING
#define STYLET_NONBLOCKING
#endif
