// Reads and writes little-endian numbers in byte buffers, on machines of any byte order.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace stylet::records {

class ByteWriter {
  public:
    explicit ByteWriter(std::vector<unsigned char>& to) : to_(&to) {}
    void u8(std::uint8_t v) { put(v, 1); }
    void u32(std::uint32_t v) { put(v, 4); }
    void u64(std::uint64_t v) { put(v, 8); }
    void f32(float v) { u32(std::bit_cast<std::uint32_t>(v)); }
    void f64(double v) { u64(std::bit_cast<std::uint64_t>(v)); }

  private:
    void put(std::uint64_t v, int count) {
        for (int i = 0; i < count; ++i)
            to_->push_back(static_cast<unsigned char>(v >> (8 * i)));
    }
    std::vector<unsigned char>* to_;
};

// Visits the numbers of a pose in the order in which the files store them.
template <typename AnyPose, typename Visit>
void eachPoseNumber(AnyPose& p, const Visit& visit) {
    visit(p.rotation.w), visit(p.rotation.x), visit(p.rotation.y), visit(p.rotation.z);
    visit(p.position_m.x), visit(p.position_m.y), visit(p.position_m.z);
}

// Reading past the end returns zeros and sets ok() to false.
class ByteReader {
  public:
    explicit ByteReader(std::span<const unsigned char> from) : from_(from) {}
    std::uint8_t u8() { return static_cast<std::uint8_t>(readBytes(1)); }
    std::uint32_t u32() { return static_cast<std::uint32_t>(readBytes(4)); }
    std::uint64_t u64() { return readBytes(8); }
    float f32() { return std::bit_cast<float>(u32()); }
    double f64() { return std::bit_cast<double>(u64()); }
    bool ok() const { return ok_; }
    std::size_t position() const { return position_; }
    std::size_t remaining() const { return from_.size() - position_; }

  private:
    std::uint64_t readBytes(std::size_t count) {
        if (remaining() < count) {
            ok_ = false;
            position_ = from_.size();
            return 0;
        }
        std::uint64_t v = 0;
        for (std::size_t i = 0; i < count; ++i)
            v |= std::uint64_t(from_[position_ + i]) << (8 * i);
        position_ += count;
        return v;
    }
    std::span<const unsigned char> from_;
    std::size_t position_ = 0;
    bool ok_ = true;
};

}  // namespace stylet::records
