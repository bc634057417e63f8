// Checks tables against the tests: hazards (hazards.toml and the tags above tests, see README.md) and fuzz
// targets (fuzz/README.md). Writes hazards.md to the build folder.
#include <gtest/gtest.h>

#include <toml++/toml.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace fs = std::filesystem;

namespace {

const fs::path kRoot = STYLET_SOURCE_DIR;

std::string read(const fs::path& file) {
    std::ifstream in(file);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
}

struct Hazard {
    std::string id, what, requirement, open;
    std::vector<std::string> mitigation;
};

struct Shown {
    std::string test, file;
};

struct Tags {
    std::map<std::string, std::vector<Shown>> of;  // by hazard id
    std::vector<std::string> complaints;
};

std::vector<Hazard> hazardsIn(std::string_view toml) {
    std::vector<Hazard> hazards;
    const toml::table table = toml::parse(toml);
    for (const toml::node& node : *table["hazard"].as_array()) {
        const toml::table& h = *node.as_table();
        const auto text = [&](const char* key) { return h[key].value_or(std::string()); };
        hazards.push_back({text("id"), text("what"), text("requirement"), text("open"), {}});
        for (const toml::node& file : *h["mitigation"].as_array())
            hazards.back().mitigation.push_back(file.value_or(std::string()));
    }
    return hazards;
}

// A tag belongs to the next test. Only comment lines may stand between a tag and its test.
void collect(const std::string& file, const std::string& text, Tags& tags) {
    static const std::regex tag("// (HZ-[A-Z0-9-]+(, HZ-[A-Z0-9-]+)*)"), id("HZ-[A-Z0-9-]+");
    static const std::regex begin("(?:TYPED_)?TEST(_F|_P)?\\((\\w+), (\\w+)\\) \\{"),
        fuzz("(extern \"C\" int LLVMFuzzer|void fuzz::parse\\().*");
    std::vector<std::string> waiting;
    std::istringstream lines(text);
    std::smatch found;
    for (std::string line; std::getline(lines, line);) {
        if (std::regex_match(line, found, tag)) {
            const std::string ids = found[1];
            for (std::sregex_iterator it(ids.begin(), ids.end(), id), end; it != end; ++it)
                waiting.push_back(it->str());
            continue;
        }
        if (line.starts_with("//") || waiting.empty()) {
            if (line.find("// HZ-") != std::string::npos)
                tags.complaints.push_back(file + ": this is no line of tags: " + line);
            continue;
        }
        std::string test;
        if (std::regex_match(line, found, begin)) test = found[2].str() + "." + found[3].str();
        if (std::regex_match(line, fuzz)) test = fs::path(file).stem().string();
        if (test.empty() || test.find("DISABLED_") != std::string::npos)
            tags.complaints.push_back(file + ": " + waiting.front() +
                                      " stands above no test that runs: " + line);
        for (const std::string& hazard : waiting)
            tags.of[hazard].push_back({test, file});
        waiting.clear();
    }
    for (const std::string& hazard : waiting)
        tags.complaints.push_back(file + ": " + hazard + " stands above no test");
}

std::vector<std::string> complaintsOf(const std::vector<Hazard>& hazards, const Tags& tags) {
    std::vector<std::string> complaints = tags.complaints;
    std::set<std::string> known;
    for (const Hazard& h : hazards) {
        if (!known.insert(h.id).second) complaints.push_back(h.id + " is there twice");
        if (h.what.empty() || h.requirement.empty() || h.mitigation.empty())
            complaints.push_back(h.id + " lacks what, requirement or mitigation");
        for (const std::string& file : h.mitigation)
            if (!fs::is_regular_file(kRoot / file)) complaints.push_back(h.id + ": there is no " + file);
        if (h.open.empty() && !tags.of.contains(h.id))
            complaints.push_back(h.id + " has no test and is not called open");
    }
    for (const auto& [hazard, tests] : tags.of)
        if (!known.contains(hazard))
            complaints.push_back(tests.front().file + ": " + hazard + " is not in tests/hazards.toml");
    return complaints;
}

// The sources and fuzz targets that the CMakeLists.txt files of the tests build.
struct Built {
    std::set<fs::path> sources;     // relative to the repository root
    std::set<std::string> fuzzing;  // FOLDER/NAME of fuzz targets
};

// Adds the sources and fuzz targets of a CMakeLists.txt in `folder`. Ignores comments.
void addBuilt(const fs::path& folder, const std::string& lists, Built& built) {
    static const std::regex comment("#[^\n]*"), command("(\\w+)\\s*\\(([^()]*)\\)");
    static const std::set<std::string> makers{"stylet_test",    "stylet_device_test", "stylet_program",
                                              "stylet_library", "add_library",        "target_sources"};
    const std::string text = std::regex_replace(lists, comment, "");
    std::vector<std::vector<std::string>> loops;
    for (std::sregex_iterator it(text.begin(), text.end(), command), end; it != end; ++it) {
        const std::string name = (*it)[1];
        std::istringstream words((*it)[2]);
        const std::vector<std::string> arguments{std::istream_iterator<std::string>(words), {}};
        if (name == "foreach") loops.push_back(arguments);
        if (name == "endforeach") loops.pop_back();
        if (name == "fuzz_target") {
            built.fuzzing.insert(arguments.at(0));
            for (const std::vector<std::string>& loop : loops)
                if (arguments[0] == "${" + loop.at(0) + "}")
                    built.fuzzing.insert(loop.begin() + 1, loop.end());
        }
        if (!makers.contains(name)) continue;
        for (std::string file : arguments) {
            if (!file.ends_with(".cpp")) continue;
            const std::string root = "${CMAKE_SOURCE_DIR}/";
            const bool from_root = file.starts_with(root);
            built.sources.insert(
                (from_root ? fs::path(file.substr(root.size())) : folder / file).lexically_normal());
        }
    }
}

Built builtTests() {
    Built built;
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / "tests"))
        if (entry.path().filename() == "CMakeLists.txt")
            addBuilt(fs::relative(entry.path().parent_path(), kRoot), read(entry.path()), built);
    for (const std::string& target : built.fuzzing)
        built.sources.insert("tests/fuzz/" + target + "_fuzz.cpp");
    return built;
}

// Tags of all test sources. Complains about a file with tags that no CMakeLists.txt builds, as its tests
// never run.
Tags tagsOfTheTests() {
    Tags tags;
    const Built built = builtTests();
    std::set<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / "tests"))
        files.insert(entry.path());
    for (const fs::path& file : files) {
        if (file.extension() != ".cpp" || file.filename() == "hazards_test.cpp") continue;
        const std::string text = read(file), name = fs::relative(file, kRoot).generic_string();
        if (text.find("// HZ-") == std::string::npos) continue;
        collect(name, text, tags);
        if (!built.sources.contains(name))
            tags.complaints.push_back(name + " has tags, and no CMakeLists.txt builds it");
    }
    return tags;
}

std::string table(const std::vector<Hazard>& hazards, const Tags& tags) {
    std::ostringstream out;
    out << "# Hazards, requirements, tests\n\nStylet is a training simulator, not a medical device, and was "
           "not "
           "evaluated to IEC 62304, ISO 14971 or IEC 60601. This table is no risk file; it says what could "
           "hurt "
           "somebody who trains, what is required against it, where that is done and which tests show it. "
           "Made "
           "from tests/hazards.toml and the tags in the tests by hazards_test.\n\n## Open\n\n";
    for (const Hazard& h : hazards)
        if (!h.open.empty()) out << "- **" << h.id << "** " << h.what << ": " << h.open << ".\n";
    out << "\n## All\n\n| hazard | what could happen | required | where | shown by "
           "|\n|---|---|---|---|---|\n";
    for (const Hazard& h : hazards) {
        out << "| " << h.id << " | " << h.what << " | " << h.requirement << " | ";
        for (const std::string& file : h.mitigation)
            out << "`" << file << "` ";
        out << "| " << (h.open.empty() ? "" : "**open** ");
        if (const auto tests = tags.of.find(h.id); tests != tags.of.end())
            for (const Shown& shown : tests->second)
                out << "`" << shown.test << "` ";
        out << "|\n";
    }
    return out.str();
}

TEST(Hazards, EachHasATestOrIsOpenAndEachTagAHazard) {
    const std::vector<Hazard> hazards = hazardsIn(read(kRoot / "tests/hazards.toml"));
    const Tags tags = tagsOfTheTests();
    EXPECT_GT(hazards.size(), 30u);
    for (const std::string& complaint : complaintsOf(hazards, tags))
        ADD_FAILURE() << complaint;
    std::ofstream(fs::path(STYLET_BINARY_DIR) / "hazards.md") << table(hazards, tags);
}

TEST(Hazards, ViolationsAreNoticed) {
    const std::string toml =
        "[[hazard]]\nid = \"HZ-A-01\"\nwhat = \"w\"\nrequirement = \"r\"\nmitigation = [\"README.md\"]\n";
    const auto count = [](const std::string& list, const std::string& test) {
        Tags tags;
        collect("a_test.cpp", test, tags);
        return complaintsOf(hazardsIn(list), tags).size();
    };
    const std::string sound = "// HZ-A-01\n// why\nTEST(A, B) {\n}\n";
    EXPECT_EQ(count(toml, sound), 0u);
    EXPECT_EQ(count(toml + "open = \"no device\"\n", "TEST(A, B) {\n"), 0u);
    EXPECT_EQ(count(toml, "TEST(A, B) {\n"), 1u);                               // hazard without a test
    EXPECT_EQ(count(toml + toml, sound), 1u);                                   // duplicate hazard
    EXPECT_EQ(count(toml, sound + "// HZ-A-02\nTEST(A, C) {\n"), 1u);           // unknown hazard
    EXPECT_EQ(count(toml, sound + "// HZ-A-01\n\nTEST(A, C) {\n"), 1u);         // tag above no test
    EXPECT_EQ(count(toml, sound + "// HZ-A-01\n"), 1u);                         // tag at the end of the file
    EXPECT_EQ(count(toml, sound + "// HZ-A-01 and more\nTEST(A, C) {\n"), 1u);  // tag inside a sentence
    EXPECT_EQ(count(toml, "// HZ-A-01\nTEST(A, DISABLED_B) {\n"), 1u);
    EXPECT_EQ(count(toml + "open = \"\"\n", "// HZ-A-01\nvoid helper() {\n"), 1u);
    EXPECT_EQ(
        count(
            "[[hazard]]\nid = \"HZ-A-01\"\nwhat = \"w\"\nrequirement = \"r\"\nmitigation = [\"gone.cpp\"]\n",
            sound),
        1u);
}

TEST(Hazards, OnlyWhatIsBuiltCounts) {
    Built built;
    addBuilt("tests/a",
             "# stylet_test(gone SOURCES gone_test.cpp)\n"
             "stylet_test(some_test\n  SOURCES b/some_test.cpp ../up.cpp  # and not_test.cpp\n"
             "  ${CMAKE_SOURCE_DIR}/tests/c.cpp)\n"
             "set_property(SOURCE named_test.cpp)\n"
             "fuzz_target(one 10)\nforeach(name two three)\nfuzz_target(${name} 10)\nendforeach()\n"
             "fuzz_target(${name} 10)\nadd_custom_target(four)\n",
             built);
    EXPECT_EQ(built.sources, (std::set<fs::path>{"tests/a/b/some_test.cpp", "tests/up.cpp", "tests/c.cpp"}));
    EXPECT_EQ(built.fuzzing, (std::set<std::string>{"one", "two", "three", "${name}"}));
}

TEST(FuzzTargets, TheTableNamesEachAndEachHasACorpus) {
    const std::string readme = read(kRoot / "tests/fuzz/README.md");
    const Built built = builtTests();
    std::set<std::string> named, there;
    static const std::regex row("\\| `(\\w+)` \\| `([^`]+)` \\|");
    for (std::sregex_iterator it(readme.begin(), readme.end(), row), end; it != end; ++it) {
        named.insert((*it)[1]);
        EXPECT_TRUE(fs::is_regular_file(kRoot / (*it)[2].str())) << (*it)[2];
    }
    const std::string ending = "_fuzz.cpp";
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / "tests/fuzz")) {
        const std::string file = fs::relative(entry.path(), kRoot / "tests/fuzz").generic_string();
        if (!file.ends_with(ending)) continue;
        const fs::path target = file.substr(0, file.size() - ending.size());
        there.insert(target.filename().string());
        EXPECT_TRUE(built.fuzzing.contains(target.generic_string())) << target << " is not built";
        EXPECT_FALSE(fs::is_empty(kRoot / "tests/fuzz/corpus" / target.filename())) << target;
    }
    EXPECT_EQ(named, there);
}

}  // namespace
