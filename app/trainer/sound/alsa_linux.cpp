#include "app/trainer/sound/alsa_linux.h"

#include <dlfcn.h>

#include <cstring>

namespace stylet::trainer {
namespace {

using Handler = void (*)(const char* file, int line, const char* function, int error, const char* format,
                         ...);

void ignoreIoError(const char*, int, const char*, int, const char*, ...) {}

}  // namespace

void quietAlsa() {
    void* const library = dlopen("libasound.so.2", RTLD_LAZY);  // never closed: OpenAL uses it too
    void* const found = library ? dlsym(library, "snd_lib_error_set_handler") : nullptr;
    if (!found) return;
    int (*set)(Handler) = nullptr;
    static_assert(sizeof set == sizeof found);
    std::memcpy(&set, &found, sizeof set);
    set(ignoreIoError);
}

}  // namespace stylet::trainer
