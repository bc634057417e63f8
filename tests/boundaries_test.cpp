// Checks the module boundaries: which modules may include and link each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace fs = std::filesystem;

namespace {

const fs::path kRoot = STYLET_SOURCE_DIR;

// A module may include and link itself, base/ and these. The mock runtime depends on no other module.
const std::map<std::string, std::set<std::string>> kAllowed = {
    {"base", {}},
    {"patient", {}},
    {"patient/displacement", {"patient"}},  // only for pictures: no force and no score may depend on it
    {"patient/synth", {"patient"}},
    {"haptics", {"patient"}},
    {"haptics/devices", {"haptics", "patient"}},
    {"render", {"patient", "patient/displacement"}},
    {"xr", {"xr/registration"}},
    {"xr/registration", {}},
    {"xr/mock", {}},
    {"app", {"patient", "patient/synth", "haptics", "haptics/devices", "render", "xr", "xr/registration"}},
    {"app/trainer",
     {"app", "patient", "patient/displacement", "patient/synth", "haptics", "haptics/devices", "render", "xr",
      "xr/registration"}},
};

// The one header of a module that others include; it lists the module's other public headers. Every header
// of base/ is public.
const std::map<std::string, std::string> kUmbrellas = {
    {"patient", "patient/patient.h"},
    {"patient/displacement", "patient/displacement/tool_displacement.h"},
    {"patient/synth", "patient/synth/synth.h"},
    {"haptics", "haptics/haptics.h"},
    {"haptics/devices", "haptics/devices/devices.h"},
    {"render", "render/render.h"},
    {"xr", "xr/xr.h"},
    {"xr/registration", "xr/registration/registration.h"},
};

// Rooms of a folder, from the ground up: a room includes only itself and rooms before it.
const std::map<std::string, std::vector<std::string>> kRooms = {
    {"patient", {"tissue", "motion", "package", "planning", "contrast"}},
    {"haptics", {"tools", "output", "loop"}},
    {"render", {"gpu", "scene", "volume", "room", "ultrasound", "fluoroscopy", "frame"}},
    {"xr/mock", {"scenario", "compositor", "control", "world", "api"}},
    {"app/modeller", {"image", "wall", "import", "check", "motion", "segmentation", "commands"}},
    {"app/trainer",
     {"stores", "session", "attempt", "hands", "sound", "view", "window", "display", "loop", "setup",
      "figures", "program"}},
};

constexpr std::size_t kMostSources = 30;  // .cpp files in a folder

std::string read(const fs::path& file) {
    std::ifstream in(file);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
}

// The most specific module that contains the file.
std::string moduleOf(const std::string& path) {
    std::string module = path.substr(0, path.find('/'));
    for (const auto& [name, allowed] : kAllowed)
        if (path.starts_with(name + "/") && name.size() > module.size()) module = name;
    return module;
}

// Why a room of `folder` must not include another, or an empty string.
std::string roomComplaint(const std::string& folder, const std::vector<std::string>& rooms,
                          const std::string& file, const std::string& header) {
    const auto floorOf = [&](const std::string& path) {
        for (std::size_t i = 0; i < rooms.size(); ++i)
            if (path.starts_with(folder + "/" + rooms[i] + "/")) return int(i);
        return -1;
    };
    const int from = floorOf(file), to = floorOf(header);
    return from >= 0 && to > from ? rooms[std::size_t(from)] + " is below " + rooms[std::size_t(to)] : "";
}

// True also for a file of a folder without rooms, and of a module inside a folder with rooms.
bool isInListedRoom(const std::string& file) {
    for (fs::path room = fs::path(file).parent_path(); !room.empty(); room = room.parent_path()) {
        if (kAllowed.contains(room.generic_string())) return true;
        const auto folder = kRooms.find(room.parent_path().generic_string());
        if (folder != kRooms.end())
            return std::count(folder->second.begin(), folder->second.end(), room.filename()) == 1;
    }
    return true;
}

std::vector<std::string> projectIncludes(const std::string& text) {
    static const std::regex include("#include [\"<]([^\">]+)[\">]");
    std::vector<std::string> found;
    for (std::sregex_iterator it(text.begin(), text.end(), include), end; it != end; ++it) {
        found.push_back((*it)[1]);
    }
    return found;
}

bool isPublic(const std::string& module, const std::string& header) {
    if (module == "base" || module == "app" || module == "app/trainer") return true;
    const std::string& umbrella = kUmbrellas.at(module);
    const std::vector<std::string> listed = projectIncludes(read(kRoot / umbrella));
    return header == umbrella || std::find(listed.begin(), listed.end(), header) != listed.end();
}

std::vector<std::string> sources(std::initializer_list<const char*> folders,
                                 const std::set<std::string>& endings) {
    std::vector<std::string> found;
    for (const char* folder : folders) {
        for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
            if (entry.is_regular_file() && endings.contains(entry.path().extension().string())) {
                found.push_back(fs::relative(entry.path(), kRoot).generic_string());
            }
        }
    }
    return found;
}

// Returns why `file` must not include `header`, or an empty string if it may.
std::string complaint(const std::string& file, const std::string& header) {
    const std::string from = moduleOf(file);
    const std::string own = from == "xr/mock" ? "xr/mock/" + header : header;  // its includes start there
    for (const auto& [folder, rooms] : kRooms)
        if (const std::string reason = roomComplaint(folder, rooms, file, own); !reason.empty())
            return reason;
    if (from == "xr/mock")
        return fs::exists(kRoot / own) || !fs::exists(kRoot / header) ? "" : "the mock stands alone";
    if (header.starts_with("..")) return "includes are from the root";
    if (!fs::exists(kRoot / header)) return "";  // generated, or from a library
    const std::string to = moduleOf(header);
    if (to == from) return "";
    if (to != "base" && !kAllowed.at(from).contains(to)) return from + " may not use " + to;
    return isPublic(to, header) ? "" : header + " is private to " + to;
}

TEST(Boundaries, IncludesPointOneWay) {
    int seen = 0;
    for (const std::string& file :
         sources({"app", "base", "haptics", "patient", "render", "xr"}, {".h", ".cpp"})) {
        for (const std::string& header : projectIncludes(read(kRoot / file))) {
            EXPECT_EQ(complaint(file, header), "") << file << " includes " << header;
            ++seen;
        }
    }
    EXPECT_GT(seen, 3000);
}

TEST(Boundaries, FoldersWithRoomsHoldNothingElseAndNoFolderIsFull) {
    for (const auto& [folder, rooms] : kRooms)
        for (const auto& entry : fs::directory_iterator(kRoot / folder)) {
            const std::string name = fs::relative(entry.path(), kRoot).generic_string();
            if (entry.path().extension() == ".cpp") ADD_FAILURE() << name << " is in no room";
            const auto umbrella = kUmbrellas.find(folder);
            if (entry.path().extension() == ".h") {
                EXPECT_TRUE(umbrella != kUmbrellas.end() && name == umbrella->second) << name;
            }
        }
    for (const std::string& file : sources({"app", "haptics", "patient", "render", "xr"}, {".h", ".cpp"}))
        EXPECT_TRUE(isInListedRoom(file)) << file;
    std::map<fs::path, std::size_t> sources_in;
    for (const std::string& file :
         sources({"app", "base", "haptics", "patient", "render", "tests", "xr"}, {".cpp"}))
        ++sources_in[fs::path(file).parent_path()];
    for (const auto& [folder, count] : sources_in)
        EXPECT_LE(count, kMostSources) << folder;
}

// The study program links no device, SQL or GPU code. tests/app/study/study_run_test.cpp checks the program
// itself.
TEST(Boundaries, TheStudyTakesOnlyThePageOfTheReports) {
    // Every program includes the first two headers.
    const std::set<std::string> page = {"app/options.h",      "app/program_linux.h", "app/report/canvas.h",
                                        "app/report/chart.h", "app/report/figure.h", "app/report/page.h"};
    int used = 0;
    for (const std::string& file : sources({"app/study"}, {".h", ".cpp"}))
        for (const std::string& header : projectIncludes(read(kRoot / file))) {
            if (header.starts_with("haptics/devices/") || header.starts_with("render/"))
                ADD_FAILURE() << file << " includes " << header;
            if (!header.starts_with("app/") || header.starts_with("app/study/")) continue;
            EXPECT_TRUE(page.contains(header)) << file << " includes " << header;
            ++used;
        }
    EXPECT_GT(used, 0);
}

TEST(Boundaries, ViolationsAreNoticed) {
    EXPECT_FALSE(isInListedRoom("app/modeller/attic/detail/floor.cpp"));
    EXPECT_NE(complaint("render/gpu/gpu.cpp", "haptics/haptics.h"), "");
    EXPECT_NE(complaint("patient/package/package.cpp", "render/render.h"), "");
    EXPECT_NE(complaint("haptics/loop/loop.cpp", "app/trainer/program/run.h"), "");
    EXPECT_NE(complaint("app/trainer/program/run.cpp", "patient/planning/planning_judge.h"), "");
    EXPECT_NE(complaint("xr/mock/api/instance.cpp", "patient/patient.h"), "");
    EXPECT_NE(complaint("xr/mock/scenario/scenario.cpp", "world/objects.h"), "");
    EXPECT_NE(complaint("base/hash.cpp", "patient/patient.h"), "");
    EXPECT_NE(complaint("app/trainer/stores/derived.cpp", "app/trainer/program/run.h"), "");
    EXPECT_NE(complaint("haptics/tools/pad.cpp", "patient/displacement/tool_displacement.h"), "");
    EXPECT_NE(complaint("app/training/score.cpp", "patient/displacement/tool_displacement.h"), "");
    EXPECT_EQ(complaint("app/trainer/view/contacts.h", "patient/displacement/tool_displacement.h"), "");
    EXPECT_NE(complaint("app/training/score.cpp", "app/trainer/session/session.h"), "");
    EXPECT_EQ(complaint("app/trainer/program/run.cpp", "app/trainer/stores/derived.h"), "");
    EXPECT_EQ(complaint("base/distance.cpp", "base/volume.h"), "");
    EXPECT_NE(complaint("haptics/tools/needle.cpp", "../patient/planning/planning_judge.h"), "");
    EXPECT_EQ(complaint("haptics/tools/needle.cpp", "patient/patient.h"), "");
    EXPECT_EQ(projectIncludes("#include <render/gpu/gpu.h>"), std::vector<std::string>{"render/gpu/gpu.h"});
}

TEST(Boundaries, ImagingLibrariesStayInTheModeller) {
    static const std::regex itk("#include [<\"](itk|gdcm)");
    for (const std::string& file :
         sources({"app", "base", "haptics", "patient", "render", "xr"}, {".h", ".cpp"})) {
        if (std::regex_search(read(kRoot / file), itk)) {
            EXPECT_TRUE(file.starts_with("app/modeller/")) << file;
        }
    }
}

std::vector<std::string> targetsIn(const std::string& text, const std::regex& pattern) {
    std::vector<std::string> found;
    for (std::sregex_iterator it(text.begin(), text.end(), pattern), end; it != end; ++it) {
        found.push_back((*it)[1]);
    }
    return found;
}

// Every library that a CMakeLists.txt names must belong to a module that its folder may use.
TEST(Boundaries, LinkListsPointOneWay) {
    static const std::regex definition("stylet_library\\((stylet_[a-z_]+)"), mention("(stylet_[a-z_]+)");
    std::vector<std::string> lists = sources({"app", "base", "haptics", "patient", "render", "xr"}, {".txt"});
    std::erase_if(lists, [](const std::string& file) { return !file.ends_with("CMakeLists.txt"); });
    std::map<std::string, std::string> module_of_target;
    for (const std::string& file : lists) {
        for (const std::string& name : targetsIn(read(kRoot / file), definition)) {
            module_of_target[name] = moduleOf(file);
        }
    }
    EXPECT_GE(module_of_target.size(), 10u);

    int seen = 0;
    for (const std::string& file : lists) {
        const std::string from = moduleOf(file);
        for (const std::string& name : targetsIn(read(kRoot / file), mention)) {
            const auto target = module_of_target.find(name);
            if (target == module_of_target.end() || target->second == from || target->second == "base")
                continue;
            EXPECT_TRUE(kAllowed.at(from).contains(target->second)) << file << " links " << name;
            ++seen;
        }
    }
    EXPECT_GT(seen, 10);
}

}  // namespace
