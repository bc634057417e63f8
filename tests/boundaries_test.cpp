// Checks the module boundaries: which modules may include and link each other.
#include <gtest/gtest.h>

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

// Modules that each module may include and link besides itself. The mock runtime depends on no other
// module.
const std::map<std::string, std::set<std::string>> kAllowed = {
    {"patient", {}}, {"haptics", {"patient"}}, {"render", {"patient"}},
    {"xr", {}},      {"xr/mock", {}},          {"app", {"patient", "haptics", "render", "xr", "app"}},
};

// Public headers of each module: its umbrella header and the headers that it includes.
const std::map<std::string, std::vector<std::string>> kUmbrellas = {
    {"patient",
     {"patient/patient.h", "patient/motion/interruption.h", "patient/synth/synth.h",
      "patient/displacement/tool_displacement.h", "base/distance.h", "base/geodesic.h",
      "patient/package/motion_io.h", "patient/package/nifti.h", "base/cache_file.h", "base/line_reader.h",
      "base/toml_reader.h", "base/whole_file.h"}},
    {"haptics",
     {"haptics/haptics.h", "haptics/devices/falcon/calibrate.h", "haptics/devices/clutch.h",
      "haptics/devices/devices.h", "haptics/devices/polled.h", "haptics/devices/replay.h",
      "haptics/devices/profiles.h"}},
    {"render", {"render/render.h"}},
    {"xr", {"xr/xr.h", "xr/registration/registration.h"}},
};

std::string read(const fs::path& file) {
    std::ifstream in(file);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
}

std::string moduleOf(const std::string& path) {
    if (path.starts_with("xr/mock/")) return "xr/mock";
    return path.substr(0, path.find('/'));
}

std::vector<std::string> projectIncludes(const std::string& text) {
    static const std::regex include("#include [\"<]([^\">]+)[\">]");
    std::vector<std::string> found;
    for (std::sregex_iterator it(text.begin(), text.end(), include), end; it != end; ++it) {
        found.push_back((*it)[1]);
    }
    return found;
}

std::set<std::string> publicHeaders(const std::string& module) {
    std::set<std::string> headers;
    for (const std::string& umbrella : kUmbrellas.at(module)) {
        headers.insert(umbrella);
        for (const std::string& header : projectIncludes(read(kRoot / umbrella)))
            headers.insert(header);
    }
    return headers;
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
    if (from == "xr/mock")
        return fs::exists(kRoot / "xr/mock" / header) || !fs::exists(kRoot / header)
                   ? ""
                   : "the mock stands alone";
    if (header.starts_with("..")) return "includes are from the root";
    if (!fs::exists(kRoot / header)) return "";  // generated, or from a library
    const std::string to = moduleOf(header);
    if (to == from) return "";
    if (!kAllowed.at(from).contains(to)) return from + " may not use " + to;
    if (to != "app" && !publicHeaders(to).contains(header)) return header + " is private to " + to;
    return "";
}

TEST(Boundaries, IncludesPointOneWay) {
    int seen = 0;
    for (const std::string& file : sources({"app", "haptics", "patient", "render", "xr"}, {".h", ".cpp"})) {
        for (const std::string& header : projectIncludes(read(kRoot / file))) {
            EXPECT_EQ(complaint(file, header), "") << file << " includes " << header;
            ++seen;
        }
    }
    EXPECT_GT(seen, 50);
}

// Tissue displacement by a tool is only for pictures. It must never affect a force or a score.
TEST(Boundaries, ToolDisplacementStaysWithThePictures) {
    int used = 0;
    for (const std::string& file : sources({"app", "haptics", "patient", "render"}, {".h", ".cpp"})) {
        if (file.starts_with("patient/tool_displacement.")) continue;
        for (const std::string& header : projectIncludes(read(kRoot / file))) {
            if (header != "patient/displacement/tool_displacement.h") continue;
            EXPECT_TRUE(file.starts_with("render/") || file.starts_with("app/trainer/")) << file;
            ++used;
        }
    }
    EXPECT_GT(used, 0);
}

// The study program links no device, SQL or GPU code. tests/app/study/study_run_test.cpp checks the program
// itself.
TEST(Boundaries, TheStudyTakesOnlyThePageOfTheReports) {
    // Every program includes the first header.
    const std::set<std::string> page = {"app/program_linux.h", "app/report/canvas.h",
                                        "app/report/chart.h",  "app/report/figure.h",
                                        "app/report/page.h",   "app/report/statistics.h"};
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
    EXPECT_NE(complaint("render/gpu/gpu.cpp", "haptics/haptics.h"), "");
    EXPECT_NE(complaint("patient/package/package.cpp", "render/render.h"), "");
    EXPECT_NE(complaint("haptics/loop/loop.cpp", "app/trainer/program/run.h"), "");
    EXPECT_NE(complaint("app/trainer/program/run.cpp", "patient/planning/planning_judge.h"), "");
    EXPECT_NE(complaint("xr/mock/instance.cpp", "patient/patient.h"), "");
    EXPECT_NE(complaint("haptics/tools/needle.cpp", "../patient/planning_judge.h"), "");
    EXPECT_EQ(complaint("haptics/tools/needle.cpp", "patient/patient.h"), "");
    EXPECT_EQ(projectIncludes("#include <render/gpu/gpu.h>"), std::vector<std::string>{"render/gpu/gpu.h"});
}

TEST(Boundaries, ImagingLibrariesStayInTheModeller) {
    static const std::regex itk("#include [<\"](itk|gdcm)");
    for (const std::string& file : sources({"app", "haptics", "patient", "render", "xr"}, {".h", ".cpp"})) {
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
    std::vector<std::string> lists = sources({"app", "haptics", "patient", "render", "xr"}, {".txt"});
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
            if (target == module_of_target.end() || target->second == from) continue;
            EXPECT_TRUE(kAllowed.at(from).contains(target->second)) << file << " links " << name;
            ++seen;
        }
    }
    EXPECT_GT(seen, 10);
}

}  // namespace
