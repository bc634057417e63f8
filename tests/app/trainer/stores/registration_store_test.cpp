// A stored registration is read back bit for bit. Every invalid file is rejected with file, field and reason.
#include "app/trainer/stores/registration_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "app/trainer/setup/register.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

using nlohmann::json;
using test::expectRefused;
using testing::HasSubstr;

Registration sample() {
    Registration r;
    r.key = {"falcon", "Novint Falcon", "stationary", "4f1c-22"};
    r.stage_from_device = {glm::angleAxis(1.1, glm::normalize(Vec3(1, 2, -3))), {0.1, 1.0 / 3.0, -0.7}};
    r.scale = 1.0045;
    r.stylus_from_tip_m = {0.001, -0.002, 0.0005};
    r.grip_from_tip_m = {0.0, -0.03, -0.11};
    r.latency_s = 0.0123;
    r.fre_m = 0.0011, r.tre_mean_m = 0.0009, r.tre_worst_m = 0.0017;
    r.centre_m = {0.0, 0.0, 0.1};
    r.points = 7, r.rejected = 1;
    r.date = "2026-11-21T20:15:00Z";
    return r;
}

TEST(RegistrationStore, RoundTripIsExact) {
    const test::TempFolder folder;
    const Registration r = sample();
    const std::filesystem::path file = registrationFile(folder / "new" / "folder", r.key);
    EXPECT_FALSE(findRegistration(folder / "new" / "folder", r.key));
    saveRegistration(r, file);
    const auto found = findRegistration(folder / "new" / "folder", r.key);
    ASSERT_TRUE(found);
    EXPECT_EQ(registrationText(*found), registrationText(r));
    EXPECT_EQ(found->stage_from_device.rotation, r.stage_from_device.rotation);
    EXPECT_EQ(found->stage_from_device.position_m, r.stage_from_device.position_m);
    EXPECT_EQ(found->latency_s, r.latency_s);
    EXPECT_EQ(found->date, r.date);
    saveRegistration(r, file);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(file.parent_path()), {}), 1)
        << "nothing half-written stays beside it";
}

TEST(RegistrationStore, AnotherSpaceOrDeviceIsAnotherFile) {
    const test::TempFolder folder;
    const Registration r = sample();
    saveRegistration(r, registrationFile(folder.path(), r.key));
    const auto other = [&](auto change) {
        RegistrationKey key = r.key;
        change(key);
        EXPECT_NE(registrationFile(folder.path(), key), registrationFile(folder.path(), r.key));
        EXPECT_FALSE(findRegistration(folder.path(), key));
    };
    other([](RegistrationKey& k) { k.generation = "4f1c-23"; });
    other([](RegistrationKey& k) { k.generation = ""; });
    other([](RegistrationKey& k) { k.space = "stage"; });
    other([](RegistrationKey& k) { k.unit = "Novint_Falcon"; });  // the same file name after escaping
    other([](RegistrationKey& k) { k.device = "bridge"; });
    other([](RegistrationKey& k) { k.unit = std::string(150, '/') + "../../etc"; });
    // A file that was copied to the name of another registration is rejected.
    RegistrationKey stage = r.key;
    stage.space = "stage";
    std::filesystem::copy_file(registrationFile(folder.path(), r.key),
                               registrationFile(folder.path(), stage));
    expectRefused([&] { findRegistration(folder.path(), stage); },
                  registrationFile(folder.path(), stage).string(), "key");
}

TEST(RegistrationStore, TheScaleAgreesAtTheCentre) {
    const Registration r = sample();
    EXPECT_LT(glm::distance(r.rigid() * r.centre_m, r.stage_from_device * (r.scale * r.centre_m)), 1e-12);
    const Vec3 off_centre = r.centre_m + Vec3(0.04, 0.0, 0.0);
    EXPECT_NEAR(glm::distance(r.rigid() * off_centre, r.stage_from_device * (r.scale * off_centre)), 0.00018,
                1e-9);
}

TEST(RegistrationStore, BadFilesAreRefusedByFieldAndReason) {
    const json good = json::parse(registrationText(sample()));
    const auto refuse = [&](const std::string& field, const std::function<void(json&)>& change) {
        json bad = good;
        change(bad);
        expectRefused([&] { parseRegistration(bad.dump(), "r.json"); }, "r.json", field);
    };
    for (const auto& [name, value] : good.items()) {
        const std::string field = name;
        refuse(field, [&](json& j) { j.erase(field); });
        refuse(field, [&](json& j) { j[field] = nullptr; });
    }
    refuse("version", [](json& j) { j["version"] = 2; });
    refuse("version", [](json& j) { j["version"] = 1.0; });
    refuse("colour", [](json& j) { j["colour"] = "red"; });
    refuse("key.room", [](json& j) { j["key"]["room"] = "red"; });
    refuse("key.device", [](json& j) { j["key"]["device"] = ""; });
    refuse("key.unit", [](json& j) { j["key"]["unit"] = std::string(201, 'x'); });
    refuse("stage_from_device.rotation_wxyz",
           [](json& j) { j["stage_from_device"]["rotation_wxyz"] = {2.0, 0.0, 0.0, 0.0}; });
    refuse("stage_from_device.rotation_wxyz",
           [](json& j) { j["stage_from_device"]["rotation_wxyz"] = {0.5, 0.0, 0.0, 0.0}; });
    refuse("stage_from_device.rotation_wxyz",
           [](json& j) { j["stage_from_device"]["rotation_wxyz"] = {1.0, 0.0, 0.0}; });
    refuse("stage_from_device.position_m", [](json& j) { j["stage_from_device"]["position_m"][1] = 1e6; });
    refuse("scale", [](json& j) { j["scale"] = 0.5; });
    refuse("scale", [](json& j) { j["scale"] = "1"; });
    refuse("latency_s", [](json& j) { j["latency_s"] = -3; });
    refuse("fre_m", [](json& j) { j["fre_m"] = -1e-9; });
    refuse("points", [](json& j) { j["points"] = 2; });
    refuse("points", [](json& j) { j["points"] = 7.5; });
    refuse("rejected", [](json& j) { j["rejected"] = 1e9; });
    for (const std::string text : {"", "{", "[]", "7", "null", "{\"version\":1e999}", "\xff\xfe"})
        expectRefused([&] { parseRegistration(text, "r.json"); }, "r.json", "");
    const std::string whole = registrationText(sample());
    for (std::size_t cut = 0; cut + 2 < whole.size(); cut += 17)
        expectRefused([&] { parseRegistration(whole.substr(0, cut), "r.json"); }, "r.json", "");
    expectRefused([&] { parseRegistration(whole + "x", "r.json"); }, "r.json", "json");
}

TEST(RegistrationStore, ReadAndWriteErrorsAreReported) {
    const test::TempFolder folder;
    expectRefused([&] { loadRegistration(folder / "none.json"); }, "none.json", "file");
    std::ofstream(folder / "huge.json") << std::string(70'000, ' ');
    expectRefused([&] { loadRegistration(folder / "huge.json"); }, "huge.json", "file");
    std::ofstream(folder / "plain") << "a file";
    expectRefused([&] { saveRegistration(sample(), folder / "plain" / "r.json"); }, "plain", "folder");
    std::filesystem::create_directory(folder / "taken.json");
    expectRefused([&] { saveRegistration(sample(), folder / "taken.json"); }, "taken.json", "file");
    Registration bad = sample();
    bad.scale = std::nan("");
    expectRefused([&] { saveRegistration(bad, folder / "bad.json"); }, "bad.json", "scale");
    bad = sample();
    bad.key.unit = "\xff";
    expectRefused([&] { saveRegistration(bad, folder / "bad.json"); }, "bad.json", "key");
    EXPECT_FALSE(std::filesystem::exists(folder / "bad.json"));
}

TEST(Register, CubeFitsTheDeviceWorkspace) {
    haptics::DeviceProfile profile;
    profile.workspace_centre_m = {0.0, 0.0, 0.1};
    profile.workspace_radius_m = 0.08;
    EXPECT_EQ(workingCube(profile, {1, 1, 1}).centre_m, profile.workspace_centre_m);
    EXPECT_EQ(workingCube(profile, {1, 1, 1}).half_m, 0.04);
    profile.workspace_radius_m = 0.04;
    EXPECT_LT(std::sqrt(3.0) * workingCube(profile, {1, 1, 1}).half_m, 0.04) << "the corners too";
    profile.workspace_radius_m = std::nan("");
    EXPECT_EQ(workingCube(profile, {1, 1, 1}).centre_m, Vec3(1, 1, 1));
}

// HZ-TEACH-06
TEST(Register, StoredRegistrationCanBeChecked) {
    const Registration r = sample();
    const xr::registration::StoredRegistration stored = toStored(r);
    const Pose stylus{glm::angleAxis(0.4, Vec3(0, 1, 0)), {0.01, 0.02, 0.03}};
    const Vec3 tip_m = r.inStage({stylus.rotation, stylus.position_m});
    xr::registration::Pair touch{stylus, {{}, tip_m - r.grip_from_tip_m}, {}};
    EXPECT_TRUE(checkDrift(stored, {&touch, 1}).valid);
    EXPECT_LT(checkDrift(stored, {&touch, 1}).moved_m, 1e-12);
    touch.stage_from_grip.position_m.x += 0.02;
    EXPECT_FALSE(checkDrift(stored, {&touch, 1}).valid);
}

}  // namespace
}  // namespace stylet::trainer
