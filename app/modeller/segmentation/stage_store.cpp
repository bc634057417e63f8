#include "app/modeller/segmentation/stage_store.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>

#include "app/modeller/check/slices.h"
#include "app/modeller/image/import_error.h"
#include "base/fields.h"
#include "base/hash.h"
#include "base/hex.h"
#include "base/whole_file.h"
#include "patient/package/nifti.h"

namespace stylet::modeller {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::size_t kMaxBytes = 4 << 20, kMaxNotes = 1000, kMaxNoteBytes = 64 << 10, kMaxAtlases = 1000;
constexpr double kMaxSeconds = 1e7;
constexpr const char *kLabels = "labels.nii.gz", *kAutomatic = "automatic.nii.gz", *kRecord = "stage.json";

bool isControl(unsigned char c) {
    return c < 32 || c == 127;
}
// Removes control characters, because a note may quote a file.
std::string sanitiseNote(std::string note) {
    std::replace_if(note.begin(), note.end(), isControl, ' ');
    return note.substr(0, kMaxNoteBytes);
}
bool isPrintable(const std::string& note) {
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

std::array<bool, 256> findChanged(const LabelVolume& automatic, const LabelVolume& edited) {
    std::array<bool, 256> changed{};
    for (std::size_t i = 0; i < edited.voxels.size(); ++i) {
        const std::uint8_t before = automatic.voxels[i], after = edited.voxels[i];
        if (before != after) changed[after != 0 ? after : before] = true;
    }
    return changed;
}

}  // namespace

std::uint64_t resultDigest(const StageResult& result) {
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
        notes.push_back(sanitiseNote(note));
    const json all{{"key", hexText(file.record.key)},
                   {"labels_digest", hexText(file.labels_digest)},
                   {"text_digest", hexText(file.text_digest)},
                   {"seconds", file.record.seconds},
                   {"corrected", file.record.corrected},
                   {"labels_replaced", file.record.labels_replaced},
                   {"atlases", file.record.atlases},
                   {"virtual_ducts", file.record.virtual_ducts},
                   {"notes", notes}};
    return all.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

StageFile parseStageFile(const fs::path& file, const std::string& text) {
    StageFile stored;
    try {
        Fields in = parseJson(file, text);
        stored.record.key = in.hex("key");
        stored.labels_digest = in.hex("labels_digest");
        stored.text_digest = in.hex("text_digest");
        stored.record.seconds = in.number("seconds", 0.0, kMaxSeconds);
        stored.record.corrected = in.flag("corrected");
        stored.record.labels_replaced = in.flag("labels_replaced");
        if (stored.record.labels_replaced && !stored.record.corrected)
            in.refuse("labels_replaced", "true, but `corrected` is false");
        stored.record.atlases = in.texts("atlases", kMaxAtlases);
        stored.record.virtual_ducts = in.flag("virtual_ducts");
        stored.record.notes = in.texts("notes", kMaxNotes, kMaxNoteBytes);
        if (!std::all_of(stored.record.notes.begin(), stored.record.notes.end(), isPrintable))
            in.refuse("notes", "control characters");
        in.finish();
    } catch (const DataError&) {
        throw DataError(file, "file",
                        "is damaged, or from an older version; remove it to compute the stage again");
    }
    return stored;
}

StageStore::StageStore(fs::path folder) : folder_(std::move(folder)) {
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error) throw ImportError(folder_.string() + ": cannot be made: " + error.message());
}

fs::path StageStore::stageFolder(int number, std::string_view name) const {
    return folder_ / ((number < 10 ? "0" : "") + std::to_string(number) + "-" + std::string(name));
}

std::optional<StageResult> StageStore::load(int number, std::string_view name, const Grid& grid,
                                            const std::string& text_name) const {
    const fs::path folder = stageFolder(number, name), record = folder / kRecord;
    if (!fs::exists(record)) return {};
    const StageFile stored = parseStageFile(record, readWholeFile(record, kMaxBytes));
    StageResult result;
    result.record = stored.record;
    result.labels = patient::readNifti<std::uint8_t>(folder / kLabels);
    if (!text_name.empty()) result.text = readWholeFile(folder / text_name, kMaxBytes);
    result.text_edited = textDigest(result.text) != stored.text_digest;
    result.labels_edited = labelsDigest(result.labels) != stored.labels_digest;
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
    if (result.record.corrected && fs::exists(folder / kAutomatic)) {
        const auto automatic = patient::readNifti<std::uint8_t>(folder / kAutomatic);
        if (automatic.grid.dims == grid.dims) result.changed = findChanged(automatic, result.labels);
    }
    return result;
}

void StageStore::saveCt(const CtVolume& ct) const {
    patient::writeNifti(folder_ / "ct.nii.gz", ct);
}

void StageStore::save(int number, std::string_view name, const StageResult& result, const CtVolume& ct,
                      const std::vector<patient::Label>& table, const std::string& text_name) const {
    const fs::path folder = stageFolder(number, name);
    fs::create_directories(folder);
    fs::remove(folder / kRecord);
    patient::writeNifti(folder / kLabels, result.labels);
    if (!result.record.labels_replaced)
        fs::copy_file(folder / kLabels, folder / kAutomatic, fs::copy_options::overwrite_existing);
    writeWholeFile(folder / "labels.ctbl", patient::colourTable(table));
    if (!text_name.empty()) writeWholeFile(folder / text_name, result.text);
    patient::Package preview;
    preview.ct = ct;
    preview.labels = result.labels;
    preview.label_table = table;
    writeSlices(preview, folder);
    writeWholeFile(folder / kRecord,
                   writeStageFile({result.record, labelsDigest(result.labels), textDigest(result.text)}));
}

}  // namespace stylet::modeller
