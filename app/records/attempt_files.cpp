#include "app/records/attempt_files.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <fstream>

#include "app/records/frames.h"
#include "patient/package/package.h"

namespace stylet::records {

namespace fs = std::filesystem;

namespace {

constexpr std::array<const char*, 2> kFrameFiles{"record/inputs.bin", "record/samples.bin"};

// Reports where the first damaged frame begins, to show what a flipped byte has cost.
std::string placeOfDamage(const fs::path& folder, const fs::path& file) {
    if (std::find(kFrameFiles.begin(), kFrameFiles.end(), file) == kFrameFiles.end()) return "";
    const WholePart whole = wholePart(folder / file);
    if (!whole.torn()) return "";
    return "; whole for " + std::to_string(whole.ticks) + " ticks, then not from byte " +
           std::to_string(whole.bytes);
}

}  // namespace

StoredFile sumOf(const fs::path& folder, const fs::path& file) {
    std::ifstream in(folder / file, std::ios::binary);
    StoredFile sum{file, 0, 0};
    std::array<char, 1 << 16> part{};
    while (in.read(part.data(), part.size()), in.gcount() > 0) {
        const auto count = std::size_t(in.gcount());
        sum.crc32 = std::uint32_t(crc32_z(sum.crc32, reinterpret_cast<unsigned char*>(part.data()), count));
        sum.bytes += count;
    }
    if (in.bad() || !in.eof()) throw DataError(folder / file, "file", "cannot be read");
    return sum;
}

std::vector<StoredFile> sumsOf(const fs::path& folder) {
    std::vector<StoredFile> sums;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file() && entry.path().filename() != kWriting)
            sums.push_back(sumOf(folder, fs::relative(entry.path(), folder)));
    std::sort(sums.begin(), sums.end(),
              [](const StoredFile& a, const StoredFile& b) { return a.file < b.file; });
    return sums;
}

std::vector<CutFile> cutTails(const fs::path& folder) {
    std::vector<CutFile> cut;
    for (const char* name : kFrameFiles) {
        const fs::path file = folder / name;
        if (!fs::exists(file)) continue;
        const WholePart whole = wholePart(file);
        cut.push_back({name, whole.ticks, whole.file_bytes - whole.bytes, whole.bytes == 0});
        if (whole.torn() && whole.bytes > 0) cutFile(file, whole.bytes);
    }
    return cut;
}

std::string damageOf(const fs::path& folder, const StoredFile& stored) {
    const fs::path file = folder / stored.file;
    try {
        if (!fs::exists(file)) return file.string() + ": is gone";
        const StoredFile now = sumOf(folder, stored.file);
        if (now.bytes != stored.bytes)
            return file.string() + ": has " + std::to_string(now.bytes) + " bytes, was stored with " +
                   std::to_string(stored.bytes) + placeOfDamage(folder, stored.file);
        if (now.crc32 != stored.crc32)
            return file.string() + ": its checksum does not match" + placeOfDamage(folder, stored.file);
    } catch (const std::exception& e) {
        return file.string() + ": cannot be checked: " + e.what();
    }
    return "";
}

std::string describe(const Recovered& recovered) {
    std::string text = "attempt " + recovered.id + " was cut short: ";
    if (recovered.files.empty()) return text + "nothing was recorded yet";
    for (std::size_t i = 0; i < recovered.files.size(); ++i) {
        const CutFile& file = recovered.files[i];
        text += (i == 0 ? "" : "; ") + file.file.string();
        if (file.headless) {
            text += " ends inside its header";
            continue;
        }
        text += " keeps " + std::to_string(file.ticks) + " ticks";
        if (file.cut_bytes > 0) text += ", " + std::to_string(file.cut_bytes) + " torn bytes cut off";
    }
    return text;
}

}  // namespace stylet::records
