// Marks functions called on the 1 kHz thread. Under clang's RealtimeSanitizer an allocation, a lock or a
// system call in such a function aborts the program. Other compilers ignore the mark.
#pragma once

#if defined(__clang__) && defined(__has_cpp_attribute)
#if __has_cpp_attribute(clang::nonblocking)
#define STYLET_NONBLOCKING [[clang::nonblocking]]
#endif
#endif
#ifndef STYLET_NONBLOCKING
#define STYLET_NONBLOCKING
#endif
