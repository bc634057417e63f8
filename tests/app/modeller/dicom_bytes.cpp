#include "dicom_bytes.h"

#include <cstdio>
#include <cstring>
#include <fstream>
#include <initializer_list>

namespace stylet::test {

namespace {

class Writer {
  public:
    std::vector<char> bytes;

    void number(std::uint32_t value, int size) {
        for (int i = 0; i < size; ++i)
            bytes.push_back(char(value >> (8 * i) & 0xff));
    }
    void text(std::uint16_t group, std::uint16_t element, const char* vr, std::string value) {
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
};

}  // namespace

std::vector<char> dicomBytes(const DicomSlice& s) {
    const std::string ct_storage = "1.2.840.10008.5.1.4.1.1.2";
    Writer meta;
    meta.head(2, 1, "OB");
    meta.number(0, 2), meta.number(2, 4), meta.number(0x0100, 2);
    meta.text(2, 2, "UI", ct_storage);
    meta.text(2, 3, "UI", s.instance);
    meta.text(2, 0x10, "UI", "1.2.840.10008.1.2.1");
    Writer w;
    w.bytes.assign(128, 0);
    for (char c : {'D', 'I', 'C', 'M'})
        w.bytes.push_back(c);
    w.head(2, 0, "UL");
    w.number(4, 2), w.number(std::uint32_t(meta.bytes.size()), 4);
    w.bytes.insert(w.bytes.end(), meta.bytes.begin(), meta.bytes.end());
    w.text(8, 0x16, "UI", ct_storage);
    w.text(8, 0x18, "UI", s.instance);
    w.text(8, 0x60, "CS", s.modality);
    w.text(0x20, 0xe, "UI", s.series);
    w.decimals(0x20, 0x32, {s.position_mm[0], s.position_mm[1], s.position_mm[2]});
    const auto& o = s.orientation;
    w.decimals(0x20, 0x37, {o[0], o[1], o[2], o[3], o[4], o[5]});
    w.word(0x28, 2, 1);
    w.text(0x28, 4, "CS", "MONOCHROME2");
    w.word(0x28, 0x10, std::uint32_t(s.rows)), w.word(0x28, 0x11, std::uint32_t(s.columns));
    w.decimals(0x28, 0x30, {s.spacing_mm[0], s.spacing_mm[1]});
    w.word(0x28, 0x100, 16), w.word(0x28, 0x101, 16), w.word(0x28, 0x102, 15), w.word(0x28, 0x103, 1);
    w.decimals(0x28, 0x1052, {s.intercept}), w.decimals(0x28, 0x1053, {s.slope});
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
