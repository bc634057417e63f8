#include "app/modeller/build/stages.h"

#include <nlohmann/json.hpp>

#include "app/modeller/build/bones.h"
#include "app/modeller/build/lungs.h"
#include "app/modeller/import_body.h"
#include "app/modeller/import_map.h"
#include "app/modeller/section.h"

namespace stylet::modeller {

using nlohmann::json;
using patient::Label;
using patient::LabelVolume;

namespace {

constexpr std::uint8_t kBody = 254;
constexpr double kSkin_m = 0.002;

std::uint8_t idOf(const char* target) {
    return findTarget(target)->id;
}

// Body: what was cut out of the air and the table when the scan was read.
void findBody(Work& work, StageResult& r) {
    r.labels = LabelVolume(work.ct.grid);
    paint(r.labels, work.body, kBody, true);
}
void takeBody(Work& work, const StageResult& r) {
    for (std::size_t i = 0; i < work.body.voxels.size(); ++i)
        work.body.voxels[i] = r.labels.voxels[i] != 0;
}

// Classes: the values of this CT, and what the thresholds alone would make of it.
json toJson(const TissueClass& c) {
    return {{"mean_hu", c.mean_hu}, {"sigma_hu", c.sigma_hu}, {"share", c.share}};
}
TissueClass classOf(const json& j) {
    return {j.at("mean_hu").get<double>(), j.at("sigma_hu").get<double>(), j.at("share").get<double>()};
}
std::string classesText(const TissueClasses& c, const patient::Thresholds& t) {
    const json all{{"lung", toJson(c.lung)},
                   {"fat", toJson(c.fat)},
                   {"soft", toJson(c.soft)},
                   {"blood", toJson(c.blood)},
                   {"bone", toJson(c.bone)},
                   {"noise_hu", c.noise_hu},
                   {"thresholds_hu",
                    {{"t0", t.t0_hu},
                     {"t1", t.t1_hu},
                     {"t2_sensitive", t.t2_sensitive_hu},
                     {"t2_specific", t.t2_specific_hu}}}};
    return all.dump(2) + "\n";
}
void readClasses(const std::string& text, TissueClasses& c, patient::Thresholds& t) {
    try {
        const json all = json::parse(text), &th = all.at("thresholds_hu");
        c = {classOf(all.at("lung")),  classOf(all.at("fat")),  classOf(all.at("soft")),
             classOf(all.at("blood")), classOf(all.at("bone")), all.at("noise_hu").get<double>()};
        t = {th.at("t0").get<double>(), th.at("t1").get<double>(), th.at("t2_sensitive").get<double>(),
             th.at("t2_specific").get<double>()};
    } catch (const json::exception& e) {
        throw ImportError(std::string("classes.json: ") + e.what());
    }
    if (!(t.t0_hu < t.t1_hu && t.t1_hu < t.t2_sensitive_hu && t.t2_sensitive_hu <= t.t2_specific_hu))
        throw ImportError("classes.json: thresholds_hu: t0 < t1 < t2_sensitive <= t2_specific does not hold");
}
void findClasses(Work& work, StageResult& r) {
    if (r.text.empty()) {
        const TissueClasses c = classesOf(work.ct, work.body);
        r.text = classesText(c, thresholdsOf(c));
        if (c.blood.share == 0.0) r.record.notes.push_back("no contrast medium is to be seen");
    }
    TissueClasses c;
    patient::Thresholds t;
    readClasses(r.text, c, t);
    r.labels = LabelVolume(work.ct.grid);
    const std::uint8_t skin = idOf("skin"), soft = idOf("muscle"), bone = idOf("bone");
    for (std::size_t i = 0; i < r.labels.voxels.size(); ++i) {
        const double hu = work.ct.voxels[i];
        if (!work.body.voxels[i] || hu < t.t0_hu) continue;
        r.labels.voxels[i] = hu < t.t1_hu ? skin : hu < t.t2_sensitive_hu ? soft : bone;
    }
}
void takeClasses(Work& work, const StageResult& r) {
    readClasses(r.text, work.classes, work.thresholds);
}

void findLungsStage(Work& work, StageResult& r) {
    const Lungs lungs = findLungs(work.ct, work.body);
    r.labels = LabelVolume(work.ct.grid);
    paint(r.labels, lungs.gas, idOf("bowel gas"), true);
    paint(r.labels, lungs.right, idOf("right lung"), true);
    paint(r.labels, lungs.left, idOf("left lung"), true);
    r.record.notes = lungs.notes;
}

void findBonesStage(Work& work, StageResult& r) {
    const Bones bones = findBones(work.ct, work.body);
    r.labels = LabelVolume(work.ct.grid);
    paint(r.labels, bones.other, idOf("bone"), true);
    paint(r.labels, bones.cartilage, idOf("cartilage and discs"), true);
    paint(r.labels, bones.spine, idOf("spine"), true);
    paint(r.labels, bones.canal, idOf("spinal canal"), true);
    paint(r.labels, bones.sternum, idOf("sternum"), true);
    paint(r.labels, bones.ribs_right, idOf("right ribs"), true);
    paint(r.labels, bones.ribs_left, idOf("left ribs"), true);
    r.record.notes = bones.notes;
}

void findSkin(Work& work, StageResult& r) {
    r.labels = LabelVolume(work.ct.grid);
    paint(r.labels, skinShell(work.body, work.scan, kSkin_m), idOf("skin"), true);
}

std::vector<Stage> makeStages() {
    return {
        {.name = "body", .find = findBody, .take = takeBody},
        {.name = "classes", .text_name = "classes.json", .find = findClasses, .take = takeClasses},
        {.name = "lungs", .gives = {"right lung", "left lung", "bowel gas"}, .find = findLungsStage},
        {.name = "bones",
         .gives = {"right ribs", "left ribs", "spine", "spinal canal", "sternum", "bone",
                   "cartilage and discs"},
         .find = findBonesStage},
        {.name = "skin", .gives = {"skin"}, .over_all = false, .find = findSkin},
    };
}

std::vector<Label> makeTable() {
    std::vector<Label> table = targetTable();
    Label body;
    body.id = kBody;
    body.name = "body";
    body.colour = {200, 160, 120};
    table.push_back(body);
    return table;
}

}  // namespace

const std::vector<Stage>& stages() {
    static const std::vector<Stage> all = makeStages();
    return all;
}

const std::vector<Label>& stageTable() {
    static const std::vector<Label> table = makeTable();
    return table;
}

}  // namespace stylet::modeller
