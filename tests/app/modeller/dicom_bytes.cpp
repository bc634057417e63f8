#include "tests/app/modeller/dicom_bytes.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <utility>

namespace stylet::test {

namespace {

class Writer {
  public:
    explicit Writer(std::set<std::uint32_t> without = {}) : without_(std::move(without)) {}
    std::vector<char> bytes;

    void number(std::uint32_t value, int size) {
        for (int i = 0; i < size; ++i)
            bytes.push_back(char(value >> (8 * i) & 0xff));
    }
    void text(std::uint16_t group, std::uint16_t element, const char* vr, std::string value) {
        if (without_.count(std::uint32_t(group) << 16 | element)) return;
        if (value.size() % 2) value += std::strcmp(vr, "UI") == 0 ? '\0' : ' ';
        head(group, element, vr);
        number(std::uint32_t(value.size()), 2);
        bytes.insert(bytes.end(), value.begin(), value.end());
    }
    void word(std::uint16_t group, std::uint16_t element, std::uint32_t value) {
        head(group, element, "US");
        number(2, 2);
        number(value, 2);
    }
    void decimals(std::uint16_t group, std::uint16_t element, std::initializer_list<double> values) {
        std::string all;
        for (double v : values) {
            char one[32];
            std::snprintf(one, sizeof one, "%.10g", v);
            all += (all.empty() ? "" : "\\") + std::string(one);
        }
        text(group, element, "DS", all);
    }
    void head(std::uint16_t group, std::uint16_t element, const char* vr) {
        number(group, 2);
        number(element, 2);
        bytes.insert(bytes.end(), vr, vr + 2);
    }
    void item(std::uint16_t element, const std::vector<char>& content) {
        number(0xfffe, 2), number(element, 2), number(std::uint32_t(content.size()), 4);
        bytes.insert(bytes.end(), content.begin(), content.end());
    }

  private:
    std::set<std::uint32_t> without_;
};

// One frame in RLE (PS3.5, annex G): the high bytes, then the low bytes, in runs of up to 128 literal
// bytes.
std::vector<char> runLength(const std::vector<std::int16_t>& stored) {
    std::array<std::vector<char>, 2> segments;
    for (int s = 0; s < 2; ++s)
        for (std::size_t i = 0; i < stored.size(); ++i) {
            if (i % 128 == 0)
                segments[std::size_t(s)].push_back(char(std::min<std::size_t>(128, stored.size() - i) - 1));
            segments[std::size_t(s)].push_back(char(std::uint16_t(stored[i]) >> (s == 0 ? 8 : 0) & 0xff));
        }
    for (auto& segment : segments)
        if (segment.size() % 2) segment.push_back(0);
    Writer w;
    w.number(2, 4), w.number(64, 4), w.number(std::uint32_t(64 + segments[0].size()), 4);
    w.bytes.resize(64, 0);
    for (const auto& segment : segments)
        w.bytes.insert(w.bytes.end(), segment.begin(), segment.end());
    return w.bytes;
}

}  // namespace

std::vector<char> dicomBytes(const DicomSlice& s) {
    Writer meta;
    meta.head(2, 1, "OB");
    meta.number(0, 2), meta.number(2, 4), meta.number(0x0100, 2);
    meta.text(2, 2, "UI", s.sop_class);
    meta.text(2, 3, "UI", s.instance);
    meta.text(2, 0x10, "UI", s.syntax);
    Writer w(s.without);
    w.bytes.assign(128, 0);
    for (char c : {'D', 'I', 'C', 'M'})
        w.bytes.push_back(c);
    w.head(2, 0, "UL");
    w.number(4, 2), w.number(std::uint32_t(meta.bytes.size()), 4);
    w.bytes.insert(w.bytes.end(), meta.bytes.begin(), meta.bytes.end());
    w.text(8, 0x16, "UI", s.sop_class);
    w.text(8, 0x18, "UI", s.instance);
    w.text(8, 0x60, "CS", s.modality);
    if (!s.description.empty()) w.text(8, 0x103e, "LO", s.description);
    w.text(0x20, 0xe, "UI", s.series);
    w.decimals(0x20, 0x32, {s.position_mm[0], s.position_mm[1], s.position_mm[2]});
    const auto& o = s.orientation;
    w.decimals(0x20, 0x37, {o[0], o[1], o[2], o[3], o[4], o[5]});
    w.word(0x28, 2, 1);
    w.text(0x28, 4, "CS", "MONOCHROME2");
    if (s.frames > 1) w.text(0x28, 8, "IS", std::to_string(s.frames));
    w.word(0x28, 0x10, std::uint32_t(s.rows)), w.word(0x28, 0x11, std::uint32_t(s.columns));
    w.decimals(0x28, 0x30, {s.spacing_mm[0], s.spacing_mm[1]});
    w.word(0x28, 0x100, 16), w.word(0x28, 0x101, 16), w.word(0x28, 0x102, 15), w.word(0x28, 0x103, 1);
    w.decimals(0x28, 0x1052, {s.intercept}), w.decimals(0x28, 0x1053, {s.slope});
    if (s.run_length) {
        w.head(0x7fe0, 0x10, "OB");
        w.number(0, 2), w.number(0xffffffff, 4);
        w.item(0xe000, {}), w.item(0xe000, runLength(s.stored)), w.item(0xe0dd, {});
        return w.bytes;
    }
    w.head(0x7fe0, 0x10, "OW");
    w.number(0, 2), w.number(std::uint32_t(s.stored.size() * 2), 4);
    for (std::int16_t v : s.stored)
        w.number(std::uint16_t(v), 2);
    return w.bytes;
}

void writeFile(const std::filesystem::path& file, const std::vector<char>& bytes) {
    std::ofstream(file, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
}

}  // namespace stylet::test
