// A probability map of organs: atlases (patients with known labels) are registered to the target and fused.
// Based on Iglesias and Sabuncu, "Multi-atlas segmentation of biomedical images: a survey", Med Image Anal
// 24, 2015 (registration, then votes weighted by local similarity, as in Artaechevarria et al. 2009, IEEE
// TMI 28).
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "app/modeller/image/limited_child_linux.h"
#include "app/modeller/image/voxel_tools.h"
#include "patient/package/package.h"

namespace stylet::modeller {

// The organs of the prior. `wall`: ribs and abdominal muscles, and everything outside them. `blood`: the
// large vessels outside the liver.
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

// Possible values of the liver's parenchyma in a CT with or without contrast medium.
inline constexpr float kMinLiver_hu = 20.0f, kMaxLiver_hu = 220.0f;

// The whole liver, as surgeons define it: parenchyma, tumours, cysts, and the vessels and ducts inside it.
Mask wholeLiver(const LabelVolume&, const std::vector<patient::Label>&);

// A bench sweeps `spacing_m`, `iterations` and `affine_share`.
struct AtlasSettings {
    double spacing_m = 0.004;  // of the grid of the registration and of the prior
    int iterations = 40;       // on the coarsest of three levels
    // Number of random points that the affine registration compares, as a share of the voxels. With 0.25 the
    // registered images are as similar as with all voxels, in a quarter of the time. With 0.1 those of a
    // reference patient differ by 7 to 27 % more.
    double affine_share = 0.25;
    // Feature difference at which an atlas's vote falls to 1/e, HU.
    double similarity_hu = 60.0;
    bool trust_axes = false;        // accept a target that looks mirrored
    std::filesystem::path scan;     // of the target; named in errors
    std::filesystem::path program;  // empty: `stylet-register` next to this program
    ChildLimits limits{.wall_s = 300, .cpu_s = 1200, .memory_bytes = std::size_t(4) << 30};
    std::function<void(std::string_view atlas)> progress = [](std::string_view) {};
};

struct AtlasPrior {
    Grid grid;  // coarse, covers the target
    // One volume per Organ, indexed by its value. They sum to 1 wherever at least one atlas covers the voxel.
    std::vector<FloatVolume> probability;
    FloatVolume known;              // share of the atlases that cover a voxel
    std::vector<std::string> used;  // names of the atlases
};

// One atlas: its features on the registration grid, and an organ for each voxel of its package.
class AtlasImage {
  public:
    AtlasImage(const patient::Package&, const AtlasSettings&);
    std::string name;
    FloatVolume feature;
    LabelVolume organ;
};

// Throws ImportError if `name` is among the names of the atlases. If a build uses the patient as its own
// atlas, the result says nothing about accuracy.
void checkNotOwnAtlas(const std::string& name, const std::vector<std::string>& atlases);

// Computes the fused prior for a target. The livers of the atlases are matched to the target's in brightness
// after the affine registration. `lungs` may be empty; then voxels below -400 HU count as lung.
// Without atlases, `known` is 0 everywhere. Throws ImportError if a registration fails or if the
// target looks mirrored.
AtlasPrior alignAtlases(const CtVolume& ct, const Mask& body, const Mask& lungs,
                        const std::vector<AtlasImage>&, const AtlasSettings&);

}  // namespace stylet::modeller
