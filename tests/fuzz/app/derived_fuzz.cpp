#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <vector>

#include "app/trainer/stores/derived.h"
#include "tests/fuzz/scratch_file.h"

// Only the unmodified cache file may be accepted. The input describes damage to that file as pairs of bytes:
// an offset and a value to add to the byte there. If one byte is left over, it is the new length of the file.
// Messages about damage are hidden.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::trainer;
    static const std::filesystem::path folder = fuzz::scratchFolder() / "derived", file = folder / "kept";
    static const std::vector<std::byte> content(70, std::byte{5});
    static const std::vector<std::uint8_t> whole = [] {
        saveDerived(file, 42, content);
        std::ifstream in(file, std::ios::binary);
        return std::vector<std::uint8_t>(std::istreambuf_iterator<char>(in), {});
    }();
    static const int shown = dup(STDERR_FILENO), nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    std::vector<std::uint8_t> bytes = whole;
    for (; size >= 2; data += 2, size -= 2)
        bytes[data[0] % bytes.size()] += data[1];
    if (size == 1) bytes.resize(data[0]);
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    dup2(nowhere, STDERR_FILENO);
    const auto found = loadDerived(file, 42);
    dup2(shown, STDERR_FILENO);
    if (found.has_value() != (bytes == whole) || (found && *found != content)) std::abort();
    return 0;
}
