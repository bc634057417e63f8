// The tissue at a point: the label if there is one, otherwise thresholds on the CT value.
// Source: Mastmeyer et al. 2017, Algorithm 1 and Table 1; for cartilage, assets/tissue/ptcd.toml.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/text.h"
#include "base/volume.h"

namespace stylet::patient {

// Rows of the force table. Other labels map to one of these and keep their own name, role and colour.
enum class Tissue : std::uint8_t { air, skin, soft, bone, fascia, liver, vessel, duct, cartilage };
inline constexpr std::array<std::string_view, 9> kTissueNames{"air",   "skin",   "soft", "bone",     "fascia",
                                                              "liver", "vessel", "duct", "cartilage"};
inline constexpr int kTissueCount = int(kTissueNames.size());
constexpr std::string_view tissueName(Tissue t) noexcept {
    return enumName(kTissueNames, t);
}
// True for the tissues that are rigid to a finger, move with the body wall and cast a shadow in ultrasound. A
// needle passes cartilage, but not bone.
constexpr bool isSkeleton(Tissue t) noexcept {
    return t == Tissue::bone || t == Tissue::cartilage;
}

// suspect: may contain a risk structure that was not recognised. Planned paths avoid it; in everything else
// it is like pass.
enum class Role : std::uint8_t { pass, risk, target, suspect };
inline constexpr std::array<std::string_view, 4> kRoleNames{"pass", "risk", "target", "suspect"};
constexpr std::string_view roleName(Role r) noexcept {
    return enumName(kRoleNames, r);
}

struct TissueRow {
    double cut_force_n = 0.0;        // T_N, infinite for bone
    double friction_n = 0.0;         // R
    double stiffness_n_per_m = 0.0;  // k
    // tenting continues until it is cut, even if the tenting depth exceeds the thickness of its mask
    bool membrane = false;
    Role role = Role::pass;
    friend bool operator==(const TissueRow&, const TissueRow&) = default;
};
using TissueTable = std::array<TissueRow, kTissueCount>;

// Elasticity of a tissue under pressure: Young's modulus at small strain, and the source of the value.
// Infinite: rigid. The row of air applies to lung and gas inside the body.
struct Elasticity {
    double young_pa = 0.0;
    std::string source;
    friend bool operator==(const Elasticity&, const Elasticity&) = default;
};
using ElasticityTable = std::array<Elasticity, kTissueCount>;

// Lower bounds of the classes [HU]: air < t0 <= skin < t1 <= soft < t2 <= bone.
struct Thresholds {
    double t0_hu = -500.0;
    double t1_hu = -200.0;
    double t2_sensitive_hu = 200.0;  // outside the fascia
    double t2_specific_hu = 300.0;   // past the fascia: >= t2_sensitive, above contrast-filled vessels
    friend bool operator==(const Thresholds&, const Thresholds&) = default;
};

// The blood in a vessel, which decides where it flows. other: a vessel of unknown type; its blood flows from
// the widest place to the thin ends. none: no vessel, or the heart, whose chambers have no flow.
enum class BloodKind : std::uint8_t { none, portal, hepatic, cava, artery, other };
inline constexpr std::array<std::string_view, 6> kBloodNames{"none",      "portal", "hepatic_vein",
                                                             "vena_cava", "artery", "other"};
inline constexpr int kBloodKindCount = int(kBloodNames.size());
constexpr std::string_view bloodName(BloodKind b) noexcept {
    return enumName(kBloodNames, b);
}

// The body part that a label shows, where its tissue alone does not say. Looks, ultrasound and the package
// check select labels by it; forces and contrast medium do not depend on it.
enum class Structure : std::uint8_t {
    other,
    fat,
    visceral_fat,
    muscle,
    diaphragm,
    cartilage,
    spine,
    spinal_canal,
    lung,
    gas,
    heart,
    gallbladder,
    tumour,
    spleen,
    kidney,
    pancreas,
    stomach,
    colon,
    small_bowel
};
inline constexpr std::array<std::string_view, 19> kStructureNames{
    "other",        "fat",      "visceral_fat", "muscle", "diaphragm",   "cartilage", "spine",
    "spinal_canal", "lung",     "gas",          "heart",  "gallbladder", "tumour",    "spleen",
    "kidney",       "pancreas", "stomach",      "colon",  "small_bowel"};
constexpr std::string_view structureName(Structure s) noexcept {
    return enumName(kStructureNames, s);
}

// One entry of a package's label table; id 0 is "unsegmented" and has no entry. Code decides by these roles,
// never by the name or the provenance, which are for people.
struct Label {
    std::uint8_t id = 0;
    std::string name;  // "right kidney"
    Tissue tissue = Tissue::soft;
    Role role = Role::pass;
    bool abdominal = false;  // a needle that enters it has passed skin and fascia
    BloodKind blood = BloodKind::none;
    Structure structure = Structure::other;
    // Contrast medium in the ducts stops where they touch it (a tumour), or drains into it (the bowel).
    bool blocks_contrast = false;
    bool drains_ducts = false;
    std::array<std::uint8_t, 3> colour{128, 128, 128};
    std::string provenance;  // "synthetic", "manual 3D-IRCADb-01", "threshold", "virtual"
    // How far the true border may lie outside the label, as the modeller estimates it; 0: exact. Planned
    // paths keep this distance from risk structures and suspects.
    double border_uncertainty_m = 0.0;
};

// Why the roles of a label contradict each other: the name of the field, and the reason.
struct RoleConflict {
    std::string_view field, reason;
};
// Returns nothing if the roles are consistent.
std::optional<RoleConflict> findRoleConflict(const Label&) noexcept;

// Flags of the needle's track; reset on withdrawal.
struct TrackFlags {
    bool past_skin = false;
    bool past_fascia = false;
};

inline constexpr std::array<TrackFlags, 4> kAllTrackFlags{
    {{false, false}, {true, false}, {false, true}, {true, true}}};

struct TissueSample {
    Tissue tissue = Tissue::air;
    std::uint8_t label = 0;  // 0 if thresholds decided
    Role role = Role::pass;  // air past the skin is a risk
    friend bool operator==(const TissueSample&, const TissueSample&) = default;
};

}  // namespace stylet::patient
