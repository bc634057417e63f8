#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <vector>

#include "app/study/result_blocks.h"
#include "tests/fuzz/scratch_file.h"

// Only the unmodified file may be accepted as a block of results. The input describes damage to that file
// in groups of three bytes: a two-byte offset and a value to add to the byte there. One byte left over
// truncates the file at that offset. Two bytes left over are appended.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::study;
    static const ResultBlocks kept(fuzz::scratchFolder(), 42, 3);
    static const std::filesystem::path file = fuzz::scratchFolder() / "000000.results";
    static const std::vector<std::uint8_t> whole = [] {
        kept.write(0, std::vector<PathResult>(3));
        std::ifstream in(file, std::ios::binary);
        return std::vector<std::uint8_t>(std::istreambuf_iterator<char>(in), {});
    }();
    std::vector<std::uint8_t> bytes = whole;
    for (; size >= 3; data += 3, size -= 3)
        bytes[std::size_t(data[0] | data[1] << 8) % bytes.size()] += data[2];
    if (size == 1) bytes.resize(data[0]);
    if (size == 2) bytes.insert(bytes.end(), data, data + 2);
    fuzz::scratchFile("000000.results", bytes.data(), bytes.size());
    if (kept.has(0) != (bytes == whole)) std::abort();
    return 0;
}
