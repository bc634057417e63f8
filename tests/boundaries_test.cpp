// The house's walls: who may include whom, and who may link whom.
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

// What each module may include and link besides itself. The mock runtime stands alone.
const std::map<std::string, std::set<std::string>> kAllowed = {
    {"patient", {}}, {"haptics", {"patient"}}, {"render", {"patient"}},
    {"xr", {}},      {"xr/mock", {}},          {"app", {"patient", "haptics", "render", "xr", "app"}},
};

// The public headers a module offers: its umbrella and what that includes.
const std::map<std::string, std::vector<std::string>> kUmbrellas = {
    {"patient", {"patient/patient.h", "patient/synth/synth.h"}},
    {"haptics", {"haptics/haptics.h", "haptics/devices/simulated.h"}},
    {"render", {"render/render.h"}},
    {"xr", {"xr/xr.h"}},
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
    static const std::regex include("#include \"([^\"]+)\"");
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

// "include X of module M from file F" -> why it is forbidden, empty when it is not.
std::string complaint(const std::string& file, const std::string& header) {
    const std::string from = moduleOf(file);
    if (from == "xr/mock")
        return fs::exists(kRoot / "xr/mock" / header) || !fs::exists(kRoot / header)
                   ? ""
                   : "the mock stands alone";
    if (!fs::exists(kRoot / header)) return "";  // generated or a library's
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

TEST(Boundaries, ViolationsAreNoticed) {
    EXPECT_NE(complaint("render/gpu.cpp", "haptics/haptics.h"), "");
    EXPECT_NE(complaint("patient/package.cpp", "render/render.h"), "");
    EXPECT_NE(complaint("haptics/loop.cpp", "app/trainer/run.h"), "");
    EXPECT_NE(complaint("app/trainer/run.cpp", "patient/nifti.h"), "");
    EXPECT_NE(complaint("xr/mock/instance.cpp", "patient/patient.h"), "");
    EXPECT_EQ(complaint("haptics/needle.cpp", "patient/patient.h"), "");
}

TEST(Boundaries, ImagingLibrariesStayInTheModeller) {
    static const std::regex itk("#include [<\"](itk|gdcm)");
    for (const std::string& file : sources({"app", "haptics", "patient", "render", "xr"}, {".h", ".cpp"})) {
        if (std::regex_search(read(kRoot / file), itk)) {
            EXPECT_TRUE(file.starts_with("app/modeller/")) << file;
        }
    }
}

// Targets are named after their folder; what a folder's CMakeLists.txt links must be allowed to it.
TEST(Boundaries, LinkListsPointOneWay) {
    const std::map<std::string, std::string> module_of_target = {
        {"stylet_patient", "patient"}, {"stylet_synth", "patient"}, {"stylet_haptics", "haptics"},
        {"stylet_devices", "haptics"}, {"stylet_render", "render"}, {"stylet_xr", "xr"},
    };
    static const std::regex word("stylet_[a-z_]+");
    int seen = 0;
    for (const std::string& file : sources({"app", "haptics", "patient", "render", "xr"}, {".txt"})) {
        if (!file.ends_with("CMakeLists.txt")) continue;
        const std::string from = moduleOf(file), text = read(kRoot / file);
        for (std::sregex_iterator it(text.begin(), text.end(), word), end; it != end; ++it) {
            const auto target = module_of_target.find(it->str());
            if (target == module_of_target.end() || target->second == from) continue;
            EXPECT_TRUE(kAllowed.at(from).contains(target->second)) << file << " links " << it->str();
            ++seen;
        }
    }
    EXPECT_GT(seen, 4);
}

}  // namespace
