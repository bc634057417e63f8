#include "patient/synth/labels.h"

#include <array>
#include <utility>

#include "patient/synth/synth.h"

namespace stylet::patient::synth {

namespace {

// Sources of the means: README.md, "What the CT shows".
constexpr std::array<CtRow, kIdCount> kCt{{
    {-1000, -1000, -1000, 0},  // air
    {-60, 45, 45, 0},          // skin: 2 mm thick, next to air, in a 1 mm CT
    {-103, -112, -60, 6},      // fat with septa
    {58, -20, 68, 5},          // muscle
    {-10, 20, 20, 0},          // fascia: between fat and muscle
    {-98, -108, 130, 8},       // visceral fat with vessels
    {410, 230, 780, 12},       // ribs
    {410, 230, 780, 12},
    {105, 105, 105, 10},     // cartilage and discs
    {270, 185, 560, 22},     // spine
    {35, 12, 45, 0},         // spinal canal
    {260, 170, 520, 15},     // sternum
    {-810, -880, -250, 10},  // lungs
    {-810, -880, -250, 10},
    {52, 60, 60, 3},     // diaphragm
    {140, 110, 162, 3},  // heart
    {170, 175, 175, 2},  // aorta
    {150, 155, 155, 4},  // vena cava
    {112, 112, 112, 4},  // liver
    {160, 170, 170, 2},  // portal vein
    {158, 168, 168, 2},  // hepatic veins
    {18, 8, 8, 1},       // ducts
    {12, 6, 45, 1},      // gallbladder
    {78, 76, 76, 4},     // tumour
    {118, 118, 118, 4},  // spleen
    {98, 102, 102, 6},   // pancreas
    {188, 150, 208, 3},  // kidneys
    {188, 150, 208, 3},
    {40, 15, 90, 3},        // stomach
    {10, -90, 90, 8},       // colon
    {60, 20, 110, 4},       // small bowel
    {-900, -980, -980, 0},  // gas
}};

Label row(Id id, std::string name, Tissue tissue, Role role, bool abdominal,
          std::array<std::uint8_t, 3> colour) {
    Label label;
    label.id = std::uint8_t(id), label.name = std::move(name);
    label.tissue = tissue, label.role = role, label.abdominal = abdominal;
    label.colour = colour, label.provenance = "synthetic";
    return label;
}

constexpr std::pair<Id, BloodKind> kBlood[] = {{Id::aorta, BloodKind::artery},
                                               {Id::cava, BloodKind::cava},
                                               {Id::portal, BloodKind::portal},
                                               {Id::hepaticVeins, BloodKind::hepatic}};
constexpr std::pair<Id, Structure> kStructures[] = {{Id::fat, Structure::fat},
                                                    {Id::muscle, Structure::muscle},
                                                    {Id::visceralFat, Structure::visceral_fat},
                                                    {Id::cartilage, Structure::cartilage},
                                                    {Id::spine, Structure::spine},
                                                    {Id::spinalCanal, Structure::spinal_canal},
                                                    {Id::lungRight, Structure::lung},
                                                    {Id::lungLeft, Structure::lung},
                                                    {Id::diaphragm, Structure::diaphragm},
                                                    {Id::heart, Structure::heart},
                                                    {Id::gallbladder, Structure::gallbladder},
                                                    {Id::tumour, Structure::tumour},
                                                    {Id::spleen, Structure::spleen},
                                                    {Id::pancreas, Structure::pancreas},
                                                    {Id::kidneyRight, Structure::kidney},
                                                    {Id::kidneyLeft, Structure::kidney},
                                                    {Id::stomach, Structure::stomach},
                                                    {Id::colon, Structure::colon},
                                                    {Id::bowel, Structure::small_bowel},
                                                    {Id::gas, Structure::gas}};

// The common duct ends at the tumour. Without it, it would drain into the bowel.
void addRoles(std::vector<Label>& table) {
    const auto of = [&](Id id) -> Label& { return table[std::size_t(id) - 1]; };
    for (const auto& [id, blood] : kBlood)
        of(id).blood = blood;
    for (const auto& [id, structure] : kStructures)
        of(id).structure = structure;
    of(Id::tumour).blocks_contrast = true;
    of(Id::bowel).drains_ducts = of(Id::gas).drains_ducts = true;
}

std::vector<Label> makeTable() {
    using enum Id;
    constexpr Role pass = Role::pass, risk = Role::risk;
    constexpr Tissue soft = Tissue::soft, bone = Tissue::bone, vessel = Tissue::vessel;
    std::vector<Label> table{
        row(skin, "skin", Tissue::skin, pass, false, {214, 164, 132}),
        row(fat, "fat of the body wall", soft, pass, false, {236, 214, 130}),
        row(muscle, "muscle", soft, pass, false, {170, 76, 64}),
        row(fascia, "fascia", Tissue::fascia, pass, false, {232, 232, 240}),
        row(visceralFat, "visceral fat", soft, pass, true, {224, 196, 96}),
        row(ribsRight, "right ribs", bone, risk, false, {241, 230, 205}),
        row(ribsLeft, "left ribs", bone, risk, false, {235, 222, 190}),
        row(cartilage, "cartilage and discs", Tissue::cartilage, risk, false, {150, 200, 210}),
        row(spine, "spine", bone, risk, false, {226, 210, 170}),
        row(spinalCanal, "spinal canal", soft, risk, false, {244, 220, 60}),
        row(sternum, "sternum", bone, risk, false, {230, 216, 180}),
        row(lungRight, "right lung", Tissue::air, risk, false, {150, 180, 214}),
        row(lungLeft, "left lung", Tissue::air, risk, false, {130, 164, 204}),
        row(diaphragm, "diaphragm", soft, pass, true, {196, 110, 96}),
        row(heart, "heart", vessel, risk, false, {206, 60, 66}),
        row(aorta, "aorta and arteries", vessel, risk, false, {224, 30, 40}),
        row(cava, "vena cava and renal veins", vessel, risk, false, {40, 90, 200}),
        row(liver, "liver", Tissue::liver, pass, true, {150, 72, 50}),
        row(portal, "portal vein", vessel, risk, true, {80, 120, 230}),
        row(hepaticVeins, "hepatic veins", vessel, risk, true, {30, 60, 150}),
        row(ducts, "bile ducts", Tissue::duct, Role::target, true, {60, 190, 70}),
        row(gallbladder, "gallbladder", soft, risk, true, {140, 200, 90}),
        row(tumour, "tumour", Tissue::liver, pass, true, {200, 150, 170}),
        row(spleen, "spleen", soft, pass, true, {140, 60, 110}),
        row(pancreas, "pancreas", soft, pass, true, {220, 160, 100}),
        row(kidneyRight, "right kidney", soft, risk, true, {190, 90, 60}),
        row(kidneyLeft, "left kidney", soft, risk, true, {180, 80, 56}),
        row(stomach, "stomach and oesophagus", soft, risk, true, {220, 140, 150}),
        row(colon, "colon", soft, risk, true, {160, 120, 80}),
        row(bowel, "small bowel", soft, risk, true, {230, 170, 140}),
        row(gas, "bowel gas", Tissue::air, risk, true, {40, 40, 60}),
    };
    addRoles(table);
    return table;
}

}  // namespace

LabelSet labelSet(IdSet ids) {
    LabelSet set{};
    for (int i = 0; i < kIdCount; ++i)
        set[std::size_t(i)] = contains(ids, std::uint8_t(i));
    return set;
}

const CtRow& ctRow(Id id) noexcept {
    return kCt[std::size_t(id)];
}

const std::vector<Label>& labelTable() {
    static const std::vector<Label> table = makeTable();
    return table;
}

}  // namespace stylet::patient::synth
