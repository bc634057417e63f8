#include "app/records/attempt_files.h"

#include <fmt/core.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <fstream>

#include "app/records/disk_linux.h"
#include "app/records/frames.h"
#include "patient/package/package.h"

namespace stylet::records {

namespace fs = std::filesystem;

namespace {

constexpr std::array<const char*, 2> kFrameFiles{"record/inputs.bin", "record/samples.bin"};

// Describes the position of the first damaged frame. Everything from there on is lost.
std::string describeDamagePosition(const fs::path& folder, const fs::path& file) {
    if (std::find(kFrameFiles.begin(), kFrameFiles.end(), file) == kFrameFiles.end()) return "";
    const IntactPart whole = findIntactPart(folder / file);
    if (!whole.torn()) return "";
    return fmt::format("; whole for {} ticks, damaged from byte {}", whole.ticks, whole.bytes);
}

}  // namespace

StoredFile computeChecksum(const fs::path& folder, const fs::path& file,
                           const std::function<void(std::span<const char>)>& visit) {
    std::ifstream in(folder / file, std::ios::binary);
    StoredFile sum{file, 0, 0};
    std::vector<char> part(1 << 20);
    while (in.read(part.data(), std::streamsize(part.size())), in.gcount() > 0) {
        const auto count = std::size_t(in.gcount());
        sum.crc32 = std::uint32_t(crc32_z(sum.crc32, reinterpret_cast<unsigned char*>(part.data()), count));
        sum.bytes += count;
        if (visit) visit({part.data(), count});
    }
    if (in.bad() || !in.eof()) throw DataError(folder / file, "file", "cannot be read");
    return sum;
}

std::vector<StoredFile> computeChecksums(const fs::path& folder) {
    std::vector<StoredFile> sums;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file() && entry.path().filename() != kLockFile)
            sums.push_back(computeChecksum(folder, fs::relative(entry.path(), folder)));
    std::sort(sums.begin(), sums.end(),
              [](const StoredFile& a, const StoredFile& b) { return a.file < b.file; });
    return sums;
}

void markImported(const fs::path& attempt_folder) {
    const fs::path file = attempt_folder / kImportedMark;
    if (fs::exists(file)) return;
    constexpr std::string_view text =
        "A store of Stylet found this folder and had not recorded it. The attempt enters no statistics.\n";
    try {
        DiskFile mark(file);
        mark.write({reinterpret_cast<const unsigned char*>(text.data()), text.size()});
        mark.sync();
    } catch (const DataError&) {
        std::error_code ignored;
        fs::remove(file, ignored);  // half a mark would count as one
        throw;
    }
    syncFolder(attempt_folder);
}

std::vector<TruncatedFile> truncateTornTails(const fs::path& folder) {
    std::vector<TruncatedFile> cut;
    for (const char* name : kFrameFiles) {
        const fs::path file = folder / name;
        if (!fs::exists(file)) continue;
        const IntactPart whole = findIntactPart(file);
        cut.push_back({name, whole.ticks, whole.file_bytes - whole.bytes, whole.bytes == 0});
        if (whole.torn() && whole.bytes > 0) truncateFile(file, whole.bytes);
    }
    return cut;
}

std::vector<std::string> findTornFiles(const fs::path& folder) {
    std::vector<std::string> torn;
    for (const char* name : kFrameFiles)
        if (fs::exists(folder / name))
            if (const std::string position = describeDamagePosition(folder, name); !position.empty())
                torn.push_back(name + position);
    return torn;
}

std::string findDamage(const fs::path& folder, const StoredFile& stored) {
    const fs::path file = folder / stored.file;
    try {
        if (!fs::exists(file)) return file.string() + ": is gone";
        const StoredFile now = computeChecksum(folder, stored.file);
        if (now.bytes != stored.bytes)
            return fmt::format("{}: has {} bytes, was stored with {}{}", file.string(), now.bytes,
                               stored.bytes, describeDamagePosition(folder, stored.file));
        if (now.crc32 != stored.crc32)
            return file.string() + ": its checksum does not match" +
                   describeDamagePosition(folder, stored.file);
    } catch (const std::exception& e) {
        return file.string() + ": cannot be checked: " + e.what();
    }
    return "";
}

std::string describe(const RecoveredAttempt& recovered) {
    std::string text = "attempt " + recovered.id + " was cut short: ";
    if (recovered.files.empty()) return text + "nothing was recorded yet";
    for (std::size_t i = 0; i < recovered.files.size(); ++i) {
        const TruncatedFile& file = recovered.files[i];
        text += (i == 0 ? "" : "; ") + file.file.string();
        if (file.header_incomplete) {
            text += " ends inside its header";
            continue;
        }
        text += fmt::format(" keeps {} ticks", file.ticks);
        if (file.truncated_bytes > 0) text += fmt::format(", {} torn bytes cut off", file.truncated_bytes);
    }
    if (!recovered.unreadable.empty()) text += "; its record cannot be read: " + recovered.unreadable;
    return text;
}

}  // namespace stylet::records
