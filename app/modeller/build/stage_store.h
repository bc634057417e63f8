// The stages of a build on disk: what a person reviews, corrects and goes on from.
//   ct.nii.gz              the CT on the working grid
//   NN-NAME/labels.nii.gz  what the stage found, with labels.ctbl, as 3D Slicer opens them over the CT
//   NN-NAME/axial.png ...  the same as films
//   NN-NAME/stage.json     key, digest, seconds, notes; written last: without it the stage is not finished
// and what else a stage leaves (a text file that can be edited).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "patient/patient.h"

namespace stylet::modeller {

struct StageRecord {
    std::uint64_t key = 0;  // digest of all that the stage depends on
    double seconds = 0.0;
    bool corrected = false;  // by a person: stands whatever its key
    std::vector<std::string> notes;
};

// What a stage found. `text` is the file beside the labels that a person may edit; empty where there is none.
struct StageResult {
    patient::LabelVolume labels;
    std::string text;
    bool text_edited = false;  // since it was kept: the labels are no longer its own
    StageRecord record;
};

// stage.json: the record, and what labels and text were when it was kept.
struct StageFile {
    StageRecord record;
    std::uint64_t labels_digest = 0, text_digest = 0;
};
std::string writeStageFile(const StageFile&);
// Throws patient::DataError in the name of `file`.
StageFile parseStageFile(const std::filesystem::path& file, const std::string& text);

class StageStore {
  public:
    // Makes the folder. Throws ImportError where it cannot be.
    explicit StageStore(std::filesystem::path folder);

    const std::filesystem::path& folder() const { return folder_; }
    // "07-liver".
    std::filesystem::path folderOf(int number, std::string_view name) const;

    // Nothing where the stage is not finished. Labels that a person changed since come as `corrected`. Throws
    // patient::DataError where they do not lie on `grid` or a file is damaged.
    std::optional<StageResult> load(int number, std::string_view name, const patient::Grid& grid,
                                    const std::string& text_name) const;
    void keepCt(const patient::CtVolume&) const;
    void keep(int number, std::string_view name, const StageResult&, const patient::CtVolume&,
              const std::vector<patient::Label>& table, const std::string& text_name) const;

  private:
    std::filesystem::path folder_;
};

std::uint64_t digestOf(const StageResult&);

}  // namespace stylet::modeller
