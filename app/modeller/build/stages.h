// Internal: what the stages of a build hand to each other, and their list.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/modeller/build/build.h"
#include "app/modeller/build/stage_store.h"
#include "app/modeller/voxel_tools.h"

namespace stylet::modeller {

// Everything on the grid of `ct`.
struct Work {
    const BuildSettings* settings = nullptr;
    patient::Grid scan;             // the scanner's own
    std::uint64_t scan_voxels = 0;  // digest of its values
    patient::CtVolume ct;           // air outside the body
    Mask body;
    patient::Thresholds thresholds;
    std::map<std::string, patient::LabelVolume> found;  // by stage
    std::map<std::string, bool> corrected;              // by a person
    std::string atlas_provenance;
    bool virtual_ducts = false;
    patient::CtVolume painted_ct;  // with virtual ducts; else empty
};

struct Stage {
    std::string_view name;
    int version = 1;                      // raised when its rules change: what was kept is done anew
    std::string_view text_name = "";      // the file a person may edit; empty where there is none
    std::vector<std::string> gives = {};  // the labels it adds to the package
    bool over_all = true;                 // or only where nothing lies yet
    // Fills labels and notes; text is empty, or a person's.
    void (*find)(Work&, StageResult&);
    // What else of a fresh or kept result goes into `Work`; its labels are in `found` already.
    void (*take)(Work&, const StageResult&) = nullptr;
};

// Of a scan's values, wherever they lie.
std::uint64_t voxelDigest(const patient::CtVolume&);

// In their order.
const std::vector<Stage>& stages();

// The labels of targetTable(), and "body".
const std::vector<patient::Label>& stageTable();

}  // namespace stylet::modeller
