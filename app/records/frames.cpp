#include "app/records/frames.h"

#include <zlib.h>

#include <fstream>
#include <vector>

#include "app/records/bytes.h"
#include "patient/package.h"

namespace stylet::records {

using patient::DataError;

namespace {

// Bytes from a file as they are asked for, with the checksum of what came since begin().
class Summed {
  public:
    explicit Summed(const std::filesystem::path& file) : stream_(file, std::ios::binary) {
        if (!stream_) throw DataError(file, "file", "cannot be read");
    }
    void begin() { bytes_.clear(); }
    bool take(std::size_t count) {
        const std::size_t before = bytes_.size();
        bytes_.resize(before + count);
        return bool(stream_.read(reinterpret_cast<char*>(bytes_.data() + before),
                                 static_cast<std::streamsize>(count)));
    }
    ByteSource from(std::size_t place) const { return ByteSource(std::span(bytes_).subspan(place)); }
    std::size_t size() const { return bytes_.size(); }
    // The next four bytes are the checksum of all so far.
    bool takeChecksum() {
        const auto sum = static_cast<std::uint32_t>(crc32_z(0, bytes_.data(), bytes_.size()));
        const std::size_t place = bytes_.size();
        return take(4) && from(place).u32() == sum;
    }

  private:
    std::ifstream stream_;
    std::vector<unsigned char> bytes_;
};

bool takeHeader(Summed& in) {
    in.begin();
    if (!in.take(kPrologueBytes)) return false;
    const std::uint32_t size = in.from(kPrologueBytes - 4).u32();
    return size <= kMaxHeaderBytes && in.take(size) && in.takeChecksum();
}

bool takeFrame(Summed& in, std::uint32_t& ticks) {
    in.begin();
    if (!in.take(kFrameHeadBytes)) return false;
    ByteSource head = in.from(0);
    const std::uint32_t mark = head.u32();
    ticks = head.u32();
    const std::uint32_t size = head.u32();
    return mark == kFrameMark && size <= kMaxFrameBytes && in.take(size) && in.takeChecksum();
}

}  // namespace

WholePart wholePart(const std::filesystem::path& file) {
    WholePart part;
    std::error_code error;
    part.file_bytes = std::filesystem::file_size(file, error);
    if (error) throw DataError(file, "file", error.message());
    Summed in(file);
    if (!takeHeader(in)) return part;
    part.bytes = in.size();
    for (std::uint32_t ticks = 0; takeFrame(in, ticks);) {
        part.bytes += in.size();
        part.ticks += ticks;
        ++part.frames;
    }
    return part;
}

}  // namespace stylet::records
