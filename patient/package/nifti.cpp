#include "patient/package/nifti.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <limits>
#include <memory>

#include "patient/package/nifti_header.h"
#include "patient/package/package.h"

namespace stylet::patient {
namespace {

constexpr std::size_t kMaxNiftiBytes = std::size_t(5) << 30;
constexpr std::size_t kMostExpansion = 1032;  // maximum expansion of deflate
constexpr std::size_t kChunkVoxels = 1 << 16;
constexpr int kCompression = 1;  // deflate's fastest: packages are loaded more often than sent

// Reads a file's bytes and inflates gzip on the fly. Never returns more than requested.
class ByteSource {
  public:
    ByteSource(const std::filesystem::path& file, std::span<const std::byte> bytes)
        : file_(file), rest_(bytes) {
        zipped_ = bytes.size() >= 2 && bytes[0] == std::byte{0x1f} && bytes[1] == std::byte{0x8b};
        most_bytes_ = zipped_ ? bytes.size() * kMostExpansion : bytes.size();
        if (zipped_ && inflateInit2(&stream_, 15 + 16) != Z_OK) throw std::bad_alloc();
    }
    ~ByteSource() {
        if (zipped_) inflateEnd(&stream_);
    }
    ByteSource(const ByteSource&) = delete;
    ByteSource& operator=(const ByteSource&) = delete;

    // Upper bound of the uncompressed size.
    std::size_t mostBytes() const { return most_bytes_; }
    void read(std::span<std::byte> out, const char* field);
    void skip(std::size_t count, const char* field);
    void expectEnd();

  private:
    // Returns up to out.size() bytes; fewer only at the end.
    std::size_t inflateInto(std::span<std::byte> out);

    const std::filesystem::path& file_;
    std::span<const std::byte> rest_;
    std::size_t most_bytes_ = 0;
    bool zipped_ = false, ended_ = false;
    z_stream stream_{};
};

std::size_t ByteSource::inflateInto(std::span<std::byte> out) {
    std::size_t done = 0;
    while (done < out.size() && !ended_) {
        const std::size_t in_now = std::min<std::size_t>(rest_.size(), 1u << 30);
        const std::size_t out_now = std::min<std::size_t>(out.size() - done, 1u << 30);
        // zlib does not modify its input, but its interface lacks const.
        stream_.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(rest_.data()));
        stream_.avail_in = uInt(in_now);
        stream_.next_out = reinterpret_cast<Bytef*>(out.data() + done);
        stream_.avail_out = uInt(out_now);
        const int result = inflate(&stream_, Z_NO_FLUSH);
        rest_ = rest_.subspan(in_now - stream_.avail_in);
        done += out_now - stream_.avail_out;
        if (result == Z_STREAM_END) ended_ = true;
        if (result == Z_BUF_ERROR) break;
        if (result != Z_OK && result != Z_STREAM_END)
            throw DataError(file_, "gzip", stream_.msg ? stream_.msg : "damaged");
    }
    return done;
}

void ByteSource::read(std::span<std::byte> out, const char* field) {
    std::size_t got = std::min(out.size(), rest_.size());
    if (zipped_) {
        got = inflateInto(out);
    } else {
        std::copy_n(rest_.begin(), got, out.begin());
        rest_ = rest_.subspan(got);
    }
    if (got < out.size()) throw DataError(file_, field, "the file ends too early");
}

void ByteSource::skip(std::size_t count, const char* field) {
    std::array<std::byte, 4096> scratch;
    while (count > 0) {
        const std::size_t now = std::min(count, scratch.size());
        read(std::span(scratch).first(now), field);
        count -= now;
    }
}

void ByteSource::expectEnd() {
    std::byte more{};
    if (zipped_ && inflateInto({&more, 1}) > 0)
        throw DataError(file_, "voxels", "more bytes than the header says");
    if (zipped_ && !ended_) throw DataError(file_, "gzip", "the file ends too early");
    if (!rest_.empty()) throw DataError(file_, "voxels", "more bytes than the header says");
}

template <typename Stored>
double decode(const std::byte* at, bool swap) noexcept {
    std::array<std::byte, sizeof(Stored)> raw;
    std::copy_n(at, sizeof(Stored), raw.begin());
    if (swap) std::reverse(raw.begin(), raw.end());
    return double(std::bit_cast<Stored>(raw));
}

using Decoder = double (*)(const std::byte*, bool) noexcept;

Decoder decoderOf(NiftiType type) {
    switch (type) {
        case NiftiType::uint8:
            return decode<std::uint8_t>;
        case NiftiType::int16:
            return decode<std::int16_t>;
        case NiftiType::uint16:
            return decode<std::uint16_t>;
        case NiftiType::int32:
            return decode<std::int32_t>;
        case NiftiType::float32:
            return decode<float>;
        case NiftiType::float64:
            return decode<double>;
    }
    return nullptr;
}

template <typename T>
constexpr NiftiType kTypeOf = sizeof(T) == 1 ? NiftiType::uint8 : NiftiType::int16;
template <>
constexpr NiftiType kTypeOf<float> = NiftiType::float32;

template <typename T>
T toVoxel(const std::filesystem::path& file, double value) {
    if constexpr (std::is_same_v<T, float>) {
        if (!(std::abs(value) <= double(std::numeric_limits<float>::max())))
            throw DataError(file, "voxels", "a value is out of range or not a number");
        return float(value);
    }
    constexpr double kLow = double(std::numeric_limits<T>::min()),
                     kHigh = double(std::numeric_limits<T>::max());
    const double whole = std::floor(value + 0.5);
    if (!(whole >= kLow && whole <= kHigh))
        throw DataError(file, "voxels", "a value is out of range or not a number");
    if (sizeof(T) == 1 && whole != value) throw DataError(file, "voxels", "a label is not a whole number");
    return T(whole);
}

template <typename T>
void readVoxels(const std::filesystem::path& file, ByteSource& in, const NiftiHeader& header,
                std::vector<T>& voxels) {
    const bool plain = header.slope == 1.0 && header.intercept == 0.0;
    if (std::is_integral_v<T> && header.type == kTypeOf<T> && !header.big_endian && plain) {
        in.read(std::as_writable_bytes(std::span(voxels)), "voxels");
        return;
    }
    const std::size_t size = bytesOf(header.type);
    const Decoder decoder = decoderOf(header.type);
    std::vector<std::byte> chunk(kChunkVoxels * size);
    for (std::size_t done = 0; done < voxels.size();) {
        const std::size_t now = std::min(kChunkVoxels, voxels.size() - done);
        in.read(std::span(chunk).first(now * size), "voxels");
        for (std::size_t i = 0; i < now; ++i) {
            const double stored = decoder(chunk.data() + i * size, header.big_endian);
            // Without scaling, values are kept bit for bit, including the sign of zero.
            voxels[done + i] = toVoxel<T>(file, plain ? stored : stored * header.slope + header.intercept);
        }
        done += now;
    }
}

template <typename T>
void undoFlips(Volume<T>& volume, const std::array<bool, 3>& flipped) {
    const std::size_t nx = std::size_t(volume.grid.dims.x), ny = std::size_t(volume.grid.dims.y);
    const std::size_t nz = std::size_t(volume.grid.dims.z), slice = nx * ny;
    T* const all = volume.voxels.data();
    if (flipped[0])
        for (std::size_t row = 0; row < ny * nz; ++row)
            std::reverse(all + row * nx, all + (row + 1) * nx);
    if (flipped[1])
        for (std::size_t z = 0; z < nz; ++z)
            for (std::size_t y = 0; y < ny / 2; ++y)
                std::swap_ranges(all + z * slice + y * nx, all + z * slice + (y + 1) * nx,
                                 all + z * slice + (ny - 1 - y) * nx);
    if (flipped[2])
        for (std::size_t z = 0; z < nz / 2; ++z)
            std::swap_ranges(all + z * slice, all + (z + 1) * slice, all + (nz - 1 - z) * slice);
}

// Writes to a file, compressed if the name ends in .gz.
class ByteSink {
  public:
    explicit ByteSink(const std::filesystem::path& file)
        : file_(file), out_(file, std::ios::binary), zipped_(file.extension() == ".gz"), buffer_(1 << 18) {
        if (!zipped_) return;
        if (deflateInit2(&stream_, kCompression, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK)
            throw std::bad_alloc();
        // No time stamp or system in the header: the same volume gives the same bytes.
        gzip_header_.os = 255;
        deflateSetHeader(&stream_, &gzip_header_);
    }
    ~ByteSink() {
        if (zipped_) deflateEnd(&stream_);
    }
    ByteSink(const ByteSink&) = delete;
    ByteSink& operator=(const ByteSink&) = delete;

    void write(std::span<const std::byte> bytes) {
        while (!bytes.empty()) {
            const std::size_t now = std::min<std::size_t>(bytes.size(), 1u << 30);
            if (zipped_)
                deflateFrom(bytes.first(now), Z_NO_FLUSH);
            else
                put(bytes.data(), now);
            bytes = bytes.subspan(now);
        }
    }
    void finish() {
        if (zipped_) deflateFrom({}, Z_FINISH);
        out_.close();
        if (out_) return;
        const int why = error_ != 0 ? error_ : errno;
        throw DataError(file_, "file", std::string("cannot be written: ") + std::strerror(why));
    }

  private:
    void put(const void* bytes, std::size_t count) {
        out_.write(static_cast<const char*>(bytes), std::streamsize(count));
        if (!out_ && error_ == 0) error_ = errno;
    }
    void deflateFrom(std::span<const std::byte> bytes, int flush) {
        stream_.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data()));
        stream_.avail_in = uInt(bytes.size());
        do {
            stream_.next_out = buffer_.data();
            stream_.avail_out = uInt(buffer_.size());
            deflate(&stream_, flush);
            put(buffer_.data(), buffer_.size() - stream_.avail_out);
        } while (stream_.avail_out == 0);
    }

    const std::filesystem::path& file_;
    std::ofstream out_;
    int error_ = 0;  // errno of the first failed write
    bool zipped_;
    std::vector<Bytef> buffer_;
    z_stream stream_{};
    gz_header gzip_header_{};
};

template <typename T>
Volume<T> parse(const std::filesystem::path& file, std::span<const std::byte> bytes, int components) {
    ByteSource in(file, bytes);
    std::array<std::byte, kNiftiHeaderBytes> head;
    in.read(head, "header");
    const NiftiHeader header = parseNiftiHeader(file, head, components);
    const std::size_t count = header.grid.voxelCount() * std::size_t(components);
    if (count * bytesOf(header.type) + header.data_offset > in.mostBytes())
        throw DataError(file, "dim", "the file is too small for the volume its header announces");
    if (components > 1 && header.flipped != std::array<bool, 3>{})
        throw DataError(file, "sform", "an axis of a vector volume runs against the patient's");
    in.skip(header.data_offset - kNiftiHeaderBytes, "extension");
    Volume<T> volume;
    volume.grid = header.grid;
    volume.voxels.resize(count);
    readVoxels(file, in, header, volume.voxels);
    in.expectEnd();
    if (components == 1) undoFlips(volume, header.flipped);
    return volume;
}

struct FileBytes {
    std::unique_ptr<std::byte[]> bytes;
    std::size_t size = 0;
    std::span<const std::byte> span() const { return {bytes.get(), size}; }
};

FileBytes readFile(const std::filesystem::path& file) {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(file, error);
    if (error) throw DataError(file, "file", "cannot be opened: " + error.message());
    if (size > kMaxNiftiBytes) throw DataError(file, "file", "larger than 5 GiB");
    FileBytes all{std::make_unique_for_overwrite<std::byte[]>(std::size_t(size)), std::size_t(size)};
    std::ifstream in(file, std::ios::binary);
    if (!in.read(reinterpret_cast<char*>(all.bytes.get()), std::streamsize(size)))
        throw DataError(file, "file", "cannot be read");
    return all;
}

}  // namespace

template <typename T>
Volume<T> parseNifti(const std::filesystem::path& file, std::span<const std::byte> bytes) {
    return parse<T>(file, bytes, 1);
}

template <typename T>
Volume<T> readNifti(const std::filesystem::path& file) {
    const FileBytes bytes = readFile(file);
    return parseNifti<T>(file, bytes.span());
}

Volume<float> parseNiftiVectors(const std::filesystem::path& file, std::span<const std::byte> bytes,
                                int components) {
    return parse<float>(file, bytes, components);
}

Volume<float> readNiftiVectors(const std::filesystem::path& file, int components) {
    const FileBytes bytes = readFile(file);
    return parseNiftiVectors(file, bytes.span(), components);
}

void writeNiftiVectors(const std::filesystem::path& file, const Volume<float>& volume, int components) {
    ByteSink out(file);
    out.write(makeNiftiHeader(NiftiType::float32, volume.grid, components));
    out.write(std::as_bytes(std::span(volume.voxels)));
    out.finish();
}

template <typename T>
void writeNifti(const std::filesystem::path& file, const Volume<T>& volume) {
    ByteSink out(file);
    out.write(makeNiftiHeader(kTypeOf<T>, volume.grid));
    out.write(std::as_bytes(std::span(volume.voxels)));
    out.finish();
}

template Volume<std::int16_t> parseNifti(const std::filesystem::path&, std::span<const std::byte>);
template Volume<std::uint8_t> parseNifti(const std::filesystem::path&, std::span<const std::byte>);
template Volume<std::int16_t> readNifti(const std::filesystem::path&);
template Volume<std::uint8_t> readNifti(const std::filesystem::path&);
template void writeNifti(const std::filesystem::path&, const Volume<std::int16_t>&);
template void writeNifti(const std::filesystem::path&, const Volume<std::uint8_t>&);

}  // namespace stylet::patient
