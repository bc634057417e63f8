#include "app/modeller/build/stage_store.h"

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>

#include "app/modeller/child_process.h"
#include "app/modeller/slices.h"
#include "patient/nifti.h"

namespace stylet::modeller {

namespace fs = std::filesystem;
using nlohmann::json;
using patient::DataError;
using patient::LabelVolume;

namespace {

constexpr const char *kLabels = "labels.nii.gz", *kRecord = "stage.json";

std::string hexOf(std::uint64_t value) {
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
    return text;
}

std::string readText(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw DataError(file, "file", "cannot be read");
    return {std::istreambuf_iterator<char>(in), {}};
}

std::uint64_t digestOf(const LabelVolume& labels) {
    patient::StateHash hash;
    hash.addBytes(std::as_bytes(std::span(labels.voxels)));
    return hash.value();
}

std::uint64_t digestOf(const std::string& text) {
    patient::StateHash hash;
    hash.add(std::string_view(text));
    return hash.value();
}

void writeText(const fs::path& file, const std::string& text) {
    std::ofstream out(file, std::ios::binary);
    out << text;
    out.close();
    if (!out) throw DataError(file, "file", "cannot be written");
}

}  // namespace

std::uint64_t digestOf(const StageResult& result) {
    patient::StateHash hash;
    hash.add(digestOf(result.labels));
    hash.add(std::string_view(result.text));
    return hash.value();
}

StageStore::StageStore(fs::path folder) : folder_(std::move(folder)) {
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error) throw ImportError(folder_.string() + ": cannot be made: " + error.message());
}

fs::path StageStore::folderOf(int number, std::string_view name) const {
    return folder_ / ((number < 10 ? "0" : "") + std::to_string(number) + "-" + std::string(name));
}

std::optional<StageResult> StageStore::load(int number, std::string_view name, const patient::Grid& grid,
                                            const std::string& text_name) const {
    const fs::path folder = folderOf(number, name), record = folder / kRecord;
    if (!fs::exists(record)) return {};
    StageResult result;
    std::string labels_digest, text_digest;
    try {
        const json read = json::parse(readText(record));
        result.record.key = std::stoull(read.at("key").get<std::string>(), nullptr, 16);
        labels_digest = read.at("labels_digest").get<std::string>();
        text_digest = read.at("text_digest").get<std::string>();
        result.record.seconds = read.at("seconds").get<double>();
        result.record.corrected = read.at("corrected").get<bool>();
        result.record.notes = read.at("notes").get<std::vector<std::string>>();
    } catch (const std::logic_error&) {
        throw DataError(record, "file", "is damaged; remove it, and the stage is done anew");
    } catch (const json::exception&) {
        throw DataError(record, "file", "is damaged; remove it, and the stage is done anew");
    }
    result.labels = patient::readNifti<std::uint8_t>(folder / kLabels);
    if (!text_name.empty()) result.text = readText(folder / text_name);
    result.text_edited = hexOf(digestOf(result.text)) != text_digest;
    if (hexOf(digestOf(result.labels)) != labels_digest) result.record.corrected = true;
    if (result.labels.grid.dims != grid.dims) {  // another voxel size: what no person made is made anew
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

void StageStore::keepCt(const patient::CtVolume& ct) const {
    patient::writeNifti(folder_ / "ct.nii.gz", ct);
}

void StageStore::keep(int number, std::string_view name, const StageResult& result,
                      const patient::CtVolume& ct, const std::vector<patient::Label>& table,
                      const std::string& text_name) const {
    const fs::path folder = folderOf(number, name);
    fs::create_directories(folder);
    fs::remove(folder / kRecord);
    patient::writeNifti(folder / kLabels, result.labels);
    writeText(folder / "labels.ctbl", patient::colourTable(table));
    if (!text_name.empty()) writeText(folder / text_name, result.text);
    patient::Package film;
    film.ct = ct;
    film.labels = result.labels;
    film.label_table = table;
    writeSlices(film, folder);
    const json record{{"key", hexOf(result.record.key)},
                      {"labels_digest", hexOf(digestOf(result.labels))},
                      {"text_digest", hexOf(digestOf(result.text))},
                      {"seconds", result.record.seconds},
                      {"corrected", result.record.corrected},
                      {"notes", result.record.notes}};
    writeText(folder / kRecord, record.dump(2) + "\n");
}

}  // namespace stylet::modeller
