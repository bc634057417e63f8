// The stages of a build on disk. A person can review and correct them, and a later run resumes from them.
//   ct.nii.gz                 the CT on the working grid
//   NN-NAME/labels.nii.gz     the stage's labels, with labels.ctbl; 3D Slicer shows them over the CT
//   NN-NAME/automatic.nii.gz  the labels that the program found, to tell which ones a person changed
//   NN-NAME/axial.png ...     the stage's labels as pictures
//   NN-NAME/stage.json        key, digests, results that are no labels, notes; written last: a stage without
//                             it is not finished
// A stage may write further files, such as a text file that can be edited.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "patient/patient.h"

namespace stylet::modeller {

struct StageRecord {
    std::uint64_t key = 0;  // digest of everything that the stage depends on
    double seconds = 0.0;
    bool corrected = false;                 // by a person: remains valid whatever its key
    std::vector<std::string> notes = {};    // for people; no stage reads them
    bool labels_replaced = false;           // `corrected` by labels passed to correctStage()
    std::vector<std::string> atlases = {};  // stage "liver": names of the atlases used
    bool virtual_ducts = false;             // stage "ducts": they are grown, not seen in the CT
};

// Result of a stage. `text` is the editable file beside the labels; empty if the stage has none.
struct StageResult {
    LabelVolume labels;
    std::string text;
    // Edited by a person since it was stored. If the text was edited, the labels are out of date.
    bool text_edited = false, labels_edited = false;
    StageRecord record;
    // By id: the labels of a corrected stage that differ from those the program found. Nothing if these are
    // not stored. A label that only lost voxels to another label has not changed.
    std::optional<std::array<bool, 256>> changed = {};
};

// stage.json: the record, and the digests of labels and text when they were stored.
struct StageFile {
    StageRecord record;
    std::uint64_t labels_digest = 0, text_digest = 0;
};
std::string writeStageFile(const StageFile&);
// Throws DataError that names `file`.
StageFile parseStageFile(const std::filesystem::path& file, const std::string& text);

class StageStore {
  public:
    // Creates the folder. Throws ImportError if that fails.
    explicit StageStore(std::filesystem::path folder);

    const std::filesystem::path& folder() const { return folder_; }
    // "07-liver".
    std::filesystem::path stageFolder(int number, std::string_view name) const;

    // Returns nothing if the stage is not finished. Also returns nothing for an unedited result on another
    // grid. Labels that a person has changed since are marked `corrected`. Throws DataError if corrected
    // labels are not on `grid` or if a file is damaged.
    std::optional<StageResult> load(int number, std::string_view name, const Grid& grid,
                                    const std::string& text_name) const;
    void saveCt(const CtVolume&) const;
    void save(int number, std::string_view name, const StageResult&, const CtVolume&,
              const std::vector<patient::Label>& table, const std::string& text_name) const;

  private:
    std::filesystem::path folder_;
};

std::uint64_t resultDigest(const StageResult&);

// Digest of a file's bytes. Throws DataError if it cannot be read.
std::uint64_t fileDigest(const std::filesystem::path&);

}  // namespace stylet::modeller
