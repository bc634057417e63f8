// Damaged contents of both files of frames, inputs.bin and samples.bin.
#include "app/records/frames.h"

#include <gtest/gtest.h>

#include <fstream>

#include "app/records/bytes.h"
#include "app/records/record.h"
#include "app/records/samples.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::records {
namespace {

using FrameBytes = std::vector<unsigned char>;

constexpr std::uint64_t kFramesTicks = 2 * kFrameTicks + 17;
constexpr std::size_t kMagicAt = 0, kVersionAt = 8, kHeaderSizeAt = 12, kHeaderAt = 16;  // offsets

struct ParsedFrames {
    std::size_t ticks = 0;
    std::uint64_t torn_bytes = 0;
};

struct InputsFormat {
    static FrameBytes make() {
        const test::TempFolder folder;
        RecordWriter writer(folder.path(), {}, {});
        for (std::uint64_t tick = 1; tick <= kFramesTicks; ++tick)
            writer.add({}, tick, tick);
        writer.finish();
        return readAll(folder / "inputs.bin");
    }
    static ParsedFrames parse(const FrameBytes& bytes) {
        Record record;
        parseInputs(bytes, "x.bin", record);
        return {record.inputs.size(), record.torn_bytes};
    }
};

struct SamplesFormat {
    static FrameBytes make() {
        const test::TempFolder folder;
        SampleWriter writer(folder.path(), {});
        for (Sample sample; sample.tick < kFramesTicks;) {
            ++sample.tick;
            writer.add(sample);
        }
        writer.finish();
        return readAll(folder / "samples.bin");
    }
    static ParsedFrames parse(const FrameBytes& bytes) {
        const Samples samples = parseSamples(bytes, "x.bin");
        return {samples.samples.size(), samples.torn_bytes};
    }
};

template <typename Format>
class FrameFile : public testing::Test {
  protected:
    static void expectRefused(const FrameBytes& bytes, const std::string& field) {
        test::expectRefused([&] { Format::parse(bytes); }, "x.bin", field);
    }
    // Steps over the header byte by byte, over the frames in larger steps.
    std::size_t next(std::size_t at) const { return at + (at <= header_bytes_ ? 1 : 499); }

    const FrameBytes bytes_ = Format::make();
    const std::size_t header_bytes_ =
        kHeaderAt + ByteReader(std::span(bytes_).subspan(kHeaderSizeAt)).u32() + 4;
};
using FrameFormats = testing::Types<InputsFormat, SamplesFormat>;
TYPED_TEST_SUITE(FrameFile, FrameFormats);

TYPED_TEST(FrameFile, ContainsEveryTick) {
    const ParsedFrames all = TypeParam::parse(this->bytes_);
    EXPECT_EQ(all.ticks, kFramesTicks);
    EXPECT_EQ(all.torn_bytes, 0u);
}

// HZ-RECORD-01
TYPED_TEST(FrameFile, IsCutAtTheLastWholeFrame) {
    for (std::size_t size = 0; size < this->bytes_.size(); size = this->next(size)) {
        const FrameBytes part(this->bytes_.begin(), this->bytes_.begin() + std::ptrdiff_t(size));
        if (size < this->header_bytes_) {
            this->expectRefused(part, "header");
            continue;
        }
        const ParsedFrames kept = TypeParam::parse(part);
        EXPECT_EQ(kept.ticks % kFrameTicks, 0u);
        EXPECT_LT(kept.ticks, kFramesTicks);
        EXPECT_LT(kept.torn_bytes, size);
    }
}

TYPED_TEST(FrameFile, ExtraBytesAreIgnoredAndReported) {
    FrameBytes bytes = this->bytes_;
    bytes.insert(bytes.end(), {'m', 'o', 'r', 'e'});
    const ParsedFrames all = TypeParam::parse(bytes);
    EXPECT_EQ(all.ticks, kFramesTicks);
    EXPECT_EQ(all.torn_bytes, 4u);
}

// HZ-RECORD-07
TYPED_TEST(FrameFile, FlippedByteIsNeverReadAsATick) {
    for (std::size_t at = 0; at < this->bytes_.size(); at = this->next(at)) {
        FrameBytes bytes = this->bytes_;
        bytes[at] ^= 0x10;
        if (at < this->header_bytes_) {
            EXPECT_THROW(TypeParam::parse(bytes), DataError) << "byte " << at;
            continue;
        }
        const ParsedFrames kept = TypeParam::parse(bytes);
        EXPECT_LT(kept.ticks, kFramesTicks) << "byte " << at;
        EXPECT_GT(kept.torn_bytes, 0u) << "byte " << at;
    }
}

// HZ-RECORD-06
TYPED_TEST(FrameFile, BadHeaderIsRefusedWithItsReason) {
    const auto with = [&](std::size_t at, unsigned char byte) {
        FrameBytes bytes = this->bytes_;
        bytes[at] = byte;
        return bytes;
    };
    this->expectRefused(with(kMagicAt, 'X'), "magic: this is not");
    this->expectRefused(with(kVersionAt, 77), "version: 77 is not");
    this->expectRefused(with(kHeaderSizeAt + 2, 0xff), "header: the file ends inside it");
    this->expectRefused(with(kHeaderAt, 0xff), "header: its checksum");
}

TYPED_TEST(FrameFile, ReadingStopsAtAnOversizedFrame) {
    for (const std::size_t field : {4u, 8u}) {  // tick count, body size
        FrameBytes bytes = this->bytes_;
        std::fill_n(bytes.begin() + std::ptrdiff_t(this->header_bytes_ + field), 4, std::uint8_t(0xff));
        EXPECT_EQ(TypeParam::parse(bytes).ticks, 0u);
    }
}

TYPED_TEST(FrameFile, IntactPartEndsBeforeTheFirstDamagedFrame) {
    const test::TempFolder temp;
    const auto intactPart = [&](const FrameBytes& bytes, std::size_t size) {
        std::ofstream(temp / "x.bin", std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(size));
        return findIntactPart(temp / "x.bin");
    };
    const std::size_t size = this->bytes_.size();
    const IntactPart all = intactPart(this->bytes_, size);
    EXPECT_EQ(all.frames, 3u);
    EXPECT_EQ(all.ticks, kFramesTicks);
    EXPECT_FALSE(all.torn());
    for (const std::size_t cut : {std::size_t(0), std::size_t(20), size / 2, size - 1}) {
        const IntactPart part = intactPart(this->bytes_, cut);
        EXPECT_LE(part.bytes, cut);
        EXPECT_EQ(part.torn(), cut > 0) << cut;
        EXPECT_EQ(part.bytes == 0, cut <= 20) << cut;
    }
    FrameBytes flipped = this->bytes_;
    flipped[size - 40] ^= 1;
    EXPECT_EQ(intactPart(flipped, size).frames, 2u);
    EXPECT_THROW(findIntactPart(temp / "nothing"), DataError);
}

}  // namespace
}  // namespace stylet::records
