#include "app/modeller/segmentation/stage_store.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>

#include "app/modeller/check/slices.h"
#include "app/modeller/image/child_process_linux.h"
#include "base/fields.h"
#include "base/hash.h"
#include "base/hex.h"
#include "base/whole_file.h"
#include "patient/package/nifti.h"

namespace stylet::modeller {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::size_t kMostBytes = 4 << 20, kMostNotes = 1000, kLongestNote = 64 << 10;
constexpr double kMostSeconds = 1e7;
constexpr const char *kLabels = "labels.nii.gz", *kRecord = "stage.json";

bool isControl(unsigned char c) {
    return c < 32 || c == 127;
}
// Removes control characters, because names of atlases come from files.
std::string printable(std::string note) {
    std::replace_if(note.begin(), note.end(), isControl, ' ');
    return note.substr(0, kLongestNote);
}
bool isNote(const std::string& note) {
    return std::none_of(note.begin(), note.end(), isControl);
}

std::uint64_t labelsDigest(const LabelVolume& labels) {
    StateHash hash;
    hash.addBytes(std::as_bytes(std::span(labels.voxels)));
    return hash.value();
}

std::uint64_t textDigest(const std::string& text) {
    StateHash hash;
    hash.add(std::string_view(text));
    return hash.value();
}

}  // namespace

std::uint64_t digestOf(const StageResult& result) {
    StateHash hash;
    hash.add(labelsDigest(result.labels));
    hash.add(std::string_view(result.text));
    return hash.value();
}

std::uint64_t fileDigest(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw DataError(file, "file", "cannot be read");
    StateHash hash;
    std::vector<char> block(1 << 20);
    while (in.read(block.data(), std::streamsize(block.size())) || in.gcount() > 0)
        hash.addBytes(std::as_bytes(std::span(block.data(), std::size_t(in.gcount()))));
    return hash.value();
}

std::string writeStageFile(const StageFile& file) {
    std::vector<std::string> notes;
    for (const std::string& note : file.record.notes)
        notes.push_back(printable(note));
    const json all{{"key", hexText(file.record.key)},          {"labels_digest", hexText(file.labels_digest)},
                   {"text_digest", hexText(file.text_digest)}, {"seconds", file.record.seconds},
                   {"corrected", file.record.corrected},       {"notes", notes}};
    return all.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

StageFile parseStageFile(const fs::path& file, const std::string& text) {
    StageFile kept;
    try {
        Fields in = parseJson(file, text);
        kept.record.key = in.hex("key");
        kept.labels_digest = in.hex("labels_digest");
        kept.text_digest = in.hex("text_digest");
        kept.record.seconds = in.number("seconds", 0.0, kMostSeconds);
        kept.record.corrected = in.flag("corrected");
        kept.record.notes = in.texts("notes", kMostNotes, kLongestNote);
        if (!std::all_of(kept.record.notes.begin(), kept.record.notes.end(), isNote))
            in.refuse("notes", "control characters");
    } catch (const DataError&) {
        throw DataError(file, "file", "is damaged; remove it to compute the stage again");
    }
    return kept;
}

StageStore::StageStore(fs::path folder) : folder_(std::move(folder)) {
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error) throw ImportError(folder_.string() + ": cannot be made: " + error.message());
}

fs::path StageStore::folderOf(int number, std::string_view name) const {
    return folder_ / ((number < 10 ? "0" : "") + std::to_string(number) + "-" + std::string(name));
}

std::optional<StageResult> StageStore::load(int number, std::string_view name, const Grid& grid,
                                            const std::string& text_name) const {
    const fs::path folder = folderOf(number, name), record = folder / kRecord;
    if (!fs::exists(record)) return {};
    const StageFile kept = parseStageFile(record, readWholeFile(record, kMostBytes));
    StageResult result;
    result.record = kept.record;
    result.labels = patient::readNifti<std::uint8_t>(folder / kLabels);
    if (!text_name.empty()) result.text = readWholeFile(folder / text_name, kMostBytes);
    result.text_edited = textDigest(result.text) != kept.text_digest;
    result.labels_edited = labelsDigest(result.labels) != kept.labels_digest;
    if (result.labels_edited) result.record.corrected = true;
    if (result.labels.grid.dims != grid.dims) {  // other voxel size: recompute if not corrected by hand
        if (result.record.corrected)
            throw DataError(folder / kLabels, "dim",
                            "a person corrected these labels on another grid than " +
                                (folder_ / "ct.nii.gz").string() +
                                " has; build with the old voxel size, or into another folder of stages");
        if (!result.text_edited) return {};
        result.labels = LabelVolume(grid);
    }
    result.labels.grid = grid;
    return result;
}

void StageStore::keepCt(const CtVolume& ct) const {
    patient::writeNifti(folder_ / "ct.nii.gz", ct);
}

void StageStore::keep(int number, std::string_view name, const StageResult& result, const CtVolume& ct,
                      const std::vector<patient::Label>& table, const std::string& text_name) const {
    const fs::path folder = folderOf(number, name);
    fs::create_directories(folder);
    fs::remove(folder / kRecord);
    patient::writeNifti(folder / kLabels, result.labels);
    writeWholeFile(folder / "labels.ctbl", patient::colourTable(table));
    if (!text_name.empty()) writeWholeFile(folder / text_name, result.text);
    patient::Package film;
    film.ct = ct;
    film.labels = result.labels;
    film.label_table = table;
    writeSlices(film, folder);
    writeWholeFile(folder / kRecord,
                   writeStageFile({result.record, labelsDigest(result.labels), textDigest(result.text)}));
}

}  // namespace stylet::modeller
