// Internal: the data shared between the stages of a build, and the list of stages.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/modeller/image/scan_blur.h"
#include "app/modeller/image/voxel_tools.h"
#include "app/modeller/segmentation/build.h"
#include "app/modeller/segmentation/stage_store.h"
#include "base/hash.h"

namespace stylet::modeller {

// All volumes are on the grid of `ct`.
struct BuildState {
    const BuildSettings* settings = nullptr;
    Grid scan;                      // the scanner's own grid
    std::uint64_t scan_voxels = 0;  // digest of the scan's values
    CtVolume ct;                    // air outside the body
    Mask body;
    std::vector<std::string> body_notes;
    ScanBlur blur;
    patient::Thresholds thresholds;
    std::map<std::string, LabelVolume> found;                       // labels, by stage name
    std::map<std::string, bool> corrected;                          // corrected by a person, by stage name
    std::map<std::string, std::array<bool, 256>> corrected_labels;  // of these stages, by stage name and id
    std::vector<std::string> atlases;                               // names of those that found the liver
    bool virtual_ducts = false;
    CtVolume painted_ct;  // with virtual ducts painted in; otherwise empty
    std::function<void(const std::string&)> progress = [](const std::string&) {};  // progress of a long stage
};

struct Stage {
    std::string_view name;
    std::string_view text_name = "";  // name of the file that a person may edit; empty if there is none
    std::vector<std::string> provides = {};  // names of the labels that it adds to the package
    bool over_all = true;                    // overwrites earlier labels; false: only unlabelled voxels
    // Fills the labels, which are all 0 before the call, and the notes. `text` is empty unless a person
    // edited it.
    void (*find)(BuildState&, StageResult&);
    // Hashes the settings that affect the result. Throws DataError if a file named in them is
    // missing.
    void (*hash_inputs)(StateHash&, const BuildSettings&) = nullptr;
    // Copies further data of a new or reused result into `BuildState`; its labels are already in `found`.
    void (*restore)(BuildState&, const StageResult&) = nullptr;
};

// Digest of a scan's values, independent of their position.
std::uint64_t voxelDigest(const CtVolume&);

// In order of execution.
const std::vector<Stage>& stages();

// The labels of targetTable(), and "body".
const std::vector<patient::Label>& stageTable();

}  // namespace stylet::modeller
