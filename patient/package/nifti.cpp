#include "patient/package/nifti.h"

#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <limits>
#include <memory>

#include "base/parallel.h"
#include "patient/package/nifti_header.h"
#include "patient/package/package.h"

namespace stylet::patient {
namespace {

constexpr std::size_t kMaxNiftiBytes = std::size_t(5) << 30;
constexpr std::size_t kMaxExpansion = 1032;  // maximum expansion of deflate
constexpr std::size_t kChunkVoxels = 1 << 16;
constexpr int kCompression = 1;  // deflate's fastest: packages are loaded more often than sent

// Reads a file's bytes and inflates gzip on the fly. Never returns more than requested.
class ByteSource {
  public:
    ByteSource(const std::filesystem::path& file, std::span<const std::byte> bytes)
        : file_(file), rest_(bytes) {
        zipped_ = bytes.size() >= 2 && bytes[0] == std::byte{0x1f} && bytes[1] == std::byte{0x8b};
        max_bytes_ = zipped_ ? bytes.size() * kMaxExpansion : bytes.size();
        if (zipped_ && inflateInit2(&stream_, 15 + 16) != Z_OK) throw std::bad_alloc();
    }
    ~ByteSource() {
        if (zipped_) inflateEnd(&stream_);
    }
    ByteSource(const ByteSource&) = delete;
    ByteSource& operator=(const ByteSource&) = delete;

    // Upper bound of the uncompressed size.
    std::size_t maxBytes() const { return max_bytes_; }
    void read(std::span<std::byte> out, const char* field) {
        std::size_t got = std::min(out.size(), rest_.size());
        if (zipped_) {
            got = inflateInto(out);
        } else {
            std::copy_n(rest_.begin(), got, out.begin());
            rest_ = rest_.subspan(got);
        }
        if (got < out.size()) throw DataError(file_, field, "the file ends too early");
    }
    void skip(std::size_t count, const char* field) {
        std::array<std::byte, 4096> scratch;
        for (std::size_t now = 0; count > 0; count -= now) {
            now = std::min(count, scratch.size());
            read(std::span(scratch).first(now), field);
        }
    }
    void expectEnd() {
        std::byte more{};
        if (zipped_ && inflateInto({&more, 1}) > 0)
            throw DataError(file_, "voxels", "more bytes than the header says");
        if (zipped_ && !ended_) throw DataError(file_, "gzip", "the file ends too early");
        if (!rest_.empty()) throw DataError(file_, "voxels", "more bytes than the header says");
    }

  private:
    // Returns up to out.size() bytes; fewer only at the end.
    std::size_t inflateInto(std::span<std::byte> out) {
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

    const std::filesystem::path& file_;
    std::span<const std::byte> rest_;
    std::size_t max_bytes_ = 0;
    bool zipped_ = false, ended_ = false;
    z_stream stream_{};
};

template <typename T>
constexpr const NiftiType& kStoredType = sizeof(T) == 1 ? kNiftiUint8 : kNiftiInt16;
template <>
constexpr const NiftiType& kStoredType<float> = kNiftiFloat32;

template <typename T>
T toVoxel(const std::filesystem::path& file, double value) {
    const double nearest = std::is_integral_v<T> ? std::floor(value + 0.5) : value;
    if (!(nearest >= double(std::numeric_limits<T>::lowest()) &&
          nearest <= double(std::numeric_limits<T>::max())))
        throw DataError(file, "voxels", "a value is out of range or not a number");
    if (sizeof(T) == 1 && nearest != value) throw DataError(file, "voxels", "a label is not a whole number");
    return T(nearest);
}

template <typename T>
void readVoxels(const std::filesystem::path& file, ByteSource& in, const NiftiHeader& header,
                std::vector<T>& voxels) {
    const bool plain = header.slope == 1.0 && header.intercept == 0.0;
    if (std::is_integral_v<T> && header.type.code == kStoredType<T>.code && !header.big_endian && plain) {
        in.read(std::as_writable_bytes(std::span(voxels)), "voxels");
        return;
    }
    const std::size_t size = header.type.bytes;
    std::vector<std::byte> chunk(kChunkVoxels * size);
    for (std::size_t done = 0; done < voxels.size();) {
        const std::size_t now = std::min(kChunkVoxels, voxels.size() - done);
        in.read(std::span(chunk).first(now * size), "voxels");
        for (std::size_t i = 0; i < now; ++i) {
            const double stored = header.type.decode(chunk.data() + i * size, header.big_endian);
            // Without scaling, values are kept bit for bit, including the sign of zero.
            voxels[done + i] = toVoxel<T>(file, plain ? stored : stored * header.slope + header.intercept);
        }
        done += now;
    }
}

template <typename T>
void undoFlips(Volume<T>& volume, const std::array<bool, 3>& flipped) {
    for (int axis = 0; axis < 3; ++axis)
        if (flipped[std::size_t(axis)])
            parallelLines(1, volume.grid.dims, axis, volume.voxels.data(),
                          [](T* first, std::size_t stride, std::size_t count) {
                              for (std::size_t i = 0; i < count / 2; ++i)
                                  std::swap(first[i * stride], first[(count - 1 - i) * stride]);
                          });
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
    if (count * header.type.bytes + header.data_offset > in.maxBytes())
        throw DataError(file, "dim", "the file is too small for the volume that its header declares");
    if (components > 1 && header.flipped != std::array<bool, 3>{})
        throw DataError(file, "sform",
                        "an axis of a vector volume is reversed; it must point along the patient's axis");
    in.skip(header.data_offset - kNiftiHeaderBytes, "extension");
    Volume<T> volume;
    volume.grid = header.grid;
    volume.voxels.resize(count);
    readVoxels(file, in, header, volume.voxels);
    in.expectEnd();
    if (components == 1) undoFlips(volume, header.flipped);
    return volume;
}

template <typename T>
void writeVolume(const std::filesystem::path& file, const Volume<T>& volume, int components) {
    ByteSink out(file);
    out.write(makeNiftiHeader(kStoredType<T>, volume.grid, components));
    out.write(std::as_bytes(std::span(volume.voxels)));
    out.finish();
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
    return parseNifti<T>(file, readFile(file).span());
}

Volume<float> parseNiftiVectors(const std::filesystem::path& file, std::span<const std::byte> bytes,
                                int components) {
    return parse<float>(file, bytes, components);
}

Volume<float> readNiftiVectors(const std::filesystem::path& file, int components) {
    return parseNiftiVectors(file, readFile(file).span(), components);
}

void writeNiftiVectors(const std::filesystem::path& file, const Volume<float>& volume, int components) {
    writeVolume(file, volume, components);
}

template <typename T>
void writeNifti(const std::filesystem::path& file, const Volume<T>& volume) {
    writeVolume(file, volume, 1);
}

template Volume<std::int16_t> parseNifti(const std::filesystem::path&, std::span<const std::byte>);
template Volume<std::uint8_t> parseNifti(const std::filesystem::path&, std::span<const std::byte>);
template Volume<std::int16_t> readNifti(const std::filesystem::path&);
template Volume<std::uint8_t> readNifti(const std::filesystem::path&);
template void writeNifti(const std::filesystem::path&, const Volume<std::int16_t>&);
template void writeNifti(const std::filesystem::path&, const Volume<std::uint8_t>&);

}  // namespace stylet::patient
