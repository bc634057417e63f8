#include "app/records/frames.h"

#include <fmt/core.h>
#include <zlib.h>

#include <cstring>
#include <fstream>
#include <string>

#include "app/records/bytes.h"
#include "patient/package/package.h"

namespace stylet::records {

namespace {

constexpr std::uint32_t kFrameMark = 0x4d415246;   // "FRAM"
constexpr std::size_t kPrologueBytes = 8 + 4 + 4;  // magic, version, header size
constexpr std::size_t kFrameHeadBytes = 4 + 4 + 4 + 8 + 8;
constexpr std::uint32_t kMaxHeaderBytes = 1 << 20;    // a recorded breath of one hour takes a third of this
constexpr std::uint32_t kMaxFrameBytes = 1 << 20;     // of the body
constexpr std::uintmax_t kMaxFileBytes = 2ull << 30;  // three hours of samples

std::uint32_t checksum(std::span<const unsigned char> bytes) {
    return static_cast<std::uint32_t>(crc32_z(0, bytes.data(), bytes.size()));
}

// Reads the head of a frame, without its body. Returns false if it is not a valid head.
bool parseFrameHead(ByteReader head, Frame& frame, std::uint32_t& body_bytes) {
    const std::uint32_t mark = head.u32();
    frame.ticks = head.u32();
    body_bytes = head.u32();
    frame.first = head.u64();
    frame.last = head.u64();
    return head.ok() && mark == kFrameMark && frame.ticks > 0 && frame.ticks <= kFrameTicks &&
           body_bytes <= kMaxFrameBytes;
}

// Reads a file on demand and computes the checksum of the bytes since begin().
class ChecksumReader {
  public:
    explicit ChecksumReader(const std::filesystem::path& file) : stream_(file, std::ios::binary) {
        if (!stream_) throw DataError(file, "file", "cannot be read");
    }
    void begin() { bytes_.clear(); }
    bool read(std::size_t count) {
        const std::size_t before = bytes_.size();
        bytes_.resize(before + count);
        return bool(stream_.read(reinterpret_cast<char*>(bytes_.data() + before),
                                 static_cast<std::streamsize>(count)));
    }
    ByteReader from(std::size_t place) const { return ByteReader(std::span(bytes_).subspan(place)); }
    std::size_t size() const { return bytes_.size(); }
    // Reads four bytes and compares them with the checksum of all bytes so far.
    bool verifyChecksum() {
        const std::uint32_t sum = checksum(bytes_);
        const std::size_t place = bytes_.size();
        return read(4) && from(place).u32() == sum;
    }

  private:
    std::ifstream stream_;
    std::vector<unsigned char> bytes_;
};

bool readHeader(ChecksumReader& in) {
    in.begin();
    if (!in.read(kPrologueBytes)) return false;
    const std::uint32_t size = in.from(kPrologueBytes - 4).u32();
    return size <= kMaxHeaderBytes && in.read(size) && in.verifyChecksum();
}

bool readFrame(ChecksumReader& in, Frame& frame) {
    in.begin();
    std::uint32_t body_bytes = 0;
    return in.read(kFrameHeadBytes) && parseFrameHead(in.from(0), frame, body_bytes) && in.read(body_bytes) &&
           in.verifyChecksum();
}

}  // namespace

FrameWriter::FrameWriter(const std::filesystem::path& file, std::span<const unsigned char> header)
    : file_(file) {
    file_.write(header);
    file_.sync();
}

void FrameWriter::add(const Frame& frame) {
    std::vector<unsigned char> bytes;
    ByteWriter sink(bytes);
    sink.u32(kFrameMark);
    sink.u32(frame.ticks);
    sink.u32(static_cast<std::uint32_t>(frame.body.size()));
    sink.u64(frame.first);
    sink.u64(frame.last);
    bytes.insert(bytes.end(), frame.body.begin(), frame.body.end());
    sink.u32(checksum(bytes));
    file_.write(bytes);
    unsynced_ticks_ += frame.ticks;
    if (unsynced_ticks_ >= kSyncTicks) sync();
}

void FrameWriter::sync() {
    file_.sync();
    unsynced_ticks_ = 0;
}

std::vector<unsigned char> encodeFileHeader(const FileKind& kind, std::span<const unsigned char> body) {
    std::vector<unsigned char> bytes(kind.magic.begin(), kind.magic.end());
    ByteWriter sink(bytes);
    sink.u32(kind.version);
    sink.u32(static_cast<std::uint32_t>(body.size()));
    bytes.insert(bytes.end(), body.begin(), body.end());
    sink.u32(checksum(bytes));
    return bytes;
}

ParsedHeader parseFileHeader(std::span<const unsigned char> bytes, const std::filesystem::path& file,
                             const FileKind& kind) {
    if (bytes.size() < kPrologueBytes) throw DataError(file, "header", "the file ends inside it");
    if (std::memcmp(bytes.data(), kind.magic.data(), kind.magic.size()) != 0)
        throw DataError(file, "magic", "this is not " + std::string(kind.what));
    ByteReader prologue(bytes.subspan(kind.magic.size()));
    const std::uint32_t version = prologue.u32(), size = prologue.u32();
    if (version != kind.version)
        throw DataError(
            file, "version",
            fmt::format(
                "{} is not {}: the file was written by {} program version; use that version to read it",
                version, kind.version, version < kind.version ? "an older" : "a newer"));
    if (size > kMaxHeaderBytes || bytes.size() < kPrologueBytes + size + 4)
        throw DataError(file, "header", "the file ends inside it");
    const auto summed = bytes.first(kPrologueBytes + size);
    if (ByteReader(bytes.subspan(summed.size())).u32() != checksum(summed))
        throw DataError(file, "header", "its checksum does not match");
    return {summed.subspan(kPrologueBytes), summed.size() + 4};
}

std::optional<Frame> parseFrame(std::span<const unsigned char> bytes) {
    Frame frame;
    std::uint32_t body_bytes = 0;
    if (!parseFrameHead(ByteReader(bytes), frame, body_bytes)) return std::nullopt;
    const std::size_t summed = kFrameHeadBytes + body_bytes;
    if (bytes.size() < summed + 4) return std::nullopt;
    if (ByteReader(bytes.subspan(summed)).u32() != checksum(bytes.first(summed))) return std::nullopt;
    frame.body = bytes.subspan(kFrameHeadBytes, body_bytes);
    frame.size = summed + 4;
    return frame;
}

std::vector<unsigned char> readAll(const std::filesystem::path& file) {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(file, error);
    if (error) throw DataError(file, "file", error.message());
    if (size > kMaxFileBytes) throw DataError(file, "file", "larger than 2 GiB");
    std::vector<unsigned char> bytes(size);
    std::ifstream stream(file, std::ios::binary);
    if (!stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
        throw DataError(file, "file", "cannot be read");
    return bytes;
}

IntactPart findIntactPart(const std::filesystem::path& file) {
    IntactPart part;
    std::error_code error;
    part.file_bytes = std::filesystem::file_size(file, error);
    if (error) throw DataError(file, "file", error.message());
    ChecksumReader in(file);
    if (!readHeader(in)) return part;
    part.bytes = in.size();
    for (Frame frame; readFrame(in, frame);) {
        part.bytes += in.size();
        part.ticks += frame.ticks;
        ++part.frames;
    }
    return part;
}

}  // namespace stylet::records
