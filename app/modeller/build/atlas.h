// Where organs probably lie: other patients whose labels are known, registered to the target and fused.
// Based on Iglesias and Sabuncu, "Multi-atlas segmentation of biomedical images: a survey", Med Image Anal
// 24, 2015 (registration, then votes weighted by local similarity, as in Artaechevarria et al. 2009, IEEE TMI
// 28).
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "app/modeller/child_process_linux.h"
#include "app/modeller/voxel_tools.h"
#include "patient/package.h"

namespace stylet::modeller {

// What the prior knows. `wall` is all that lies outside ribs and abdominal muscles, they included; `blood`
// the large vessels outside the liver.
enum class Organ : std::uint8_t {
    elsewhere,
    liver,
    gallbladder,
    spleen,
    heart,
    kidneys,
    stomach,
    bowel,
    pancreas,
    blood,
    lungs,
    wall
};
inline constexpr std::size_t kOrgans = std::size_t(Organ::wall) + 1;

// The liver as a surgeon means it: parenchyma, tumours, cysts and the vessels and ducts inside.
Mask wholeLiver(const patient::LabelVolume&, const std::vector<patient::Label>&);

struct AtlasSettings {
    // The grid of registration and of the prior; a bench sweeps these two.
    double spacing_m = 0.004;
    int iterations = 40;  // on the coarsest of three levels
    // Of features that differ, at which an atlas's vote falls to 1/e, HU.
    double similarity_hu = 60.0;
    std::filesystem::path program;  // empty: `stylet-register` beside this program
    ChildLimits limits{.wall_s = 300, .cpu_s = 1200, .memory_bytes = std::size_t(4) << 30};
    std::function<void(std::string_view atlas)> progress = [](std::string_view) {};
};

struct AtlasPrior {
    patient::Grid grid;  // coarse, covers the target
    // Of each Organ, by its number; they sum to 1 where any atlas reaches.
    std::vector<FloatVolume> probability;
    FloatVolume known;              // share of the atlases that reach a voxel
    std::vector<std::string> used;  // names of the atlases, for the provenance
};

// One atlas on the grid of registration: features, and an organ per voxel. A package is many times larger.
class AtlasImage {
  public:
    AtlasImage(const patient::Package&, const AtlasSettings&);
    std::string name;
    FloatVolume feature;
    patient::LabelVolume organ;
};

// What a provenance says of the atlases used: atlases: "A", "B". Nothing where there are none.
std::string atlasList(const std::vector<std::string>& names);
// What is built with a patient among its atlases proves nothing about him. Throws ImportError where `listed`
// has `name` in an atlasList().
void refuseItself(const std::string& name, const std::string& listed);

// The fused prior for a target. `lungs` may be empty (then what is lighter than lung and fat counts). No
// atlases give a prior with nothing known. Throws ImportError where a registration fails.
AtlasPrior alignAtlases(const patient::CtVolume& ct, const Mask& body, const Mask& lungs,
                        const std::vector<AtlasImage>&, const AtlasSettings&);

}  // namespace stylet::modeller
