// Reads packaging/udev as udev does (man 7 udev) and compares it with the drivers' device lists.
#include <gtest/gtest.h>

#include <fmt/core.h>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "haptics/devices/spacemouse/spacemouse_report.h"

namespace stylet::haptics {
namespace {

namespace fs = std::filesystem;

struct Clause {
    std::string key, op, value;
};
using Rule = std::vector<Clause>;

fs::path folder() {
    return fs::path(STYLET_SOURCE_DIR) / "packaging" / "udev";
}

std::vector<Rule> rulesIn(const fs::path& file) {
    static const std::regex clause(R"(^\s*([A-Z]+(?:\{[A-Za-z]+\})?)\s*(==|!=|\+=|=)\s*"([^"]*)\"\s*(,|$))");
    std::vector<Rule> rules;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) {
        if (line.empty() || line[0] == '#') continue;
        Rule rule;
        for (std::smatch found; !line.empty() && std::regex_search(line, found, clause);
             line = found.suffix().str())
            rule.push_back({found[1], found[2], found[3]});
        EXPECT_EQ(line, "") << file << ": cannot be read as key, operator, value";
        rules.push_back(rule);
    }
    return rules;
}

bool oneOf(const std::string& list, const std::string& value) {
    return ("|" + list + "|").find("|" + value + "|") != std::string::npos;
}

std::string hex(unsigned number) {
    return fmt::format("{:04x}", number);
}

// True if the rules give the user access to a USB device with these ids.
bool allows(const std::vector<Rule>& rules, const std::string& attribute, unsigned vendor, unsigned product) {
    for (const Rule& rule : rules) {
        bool tags = false, matches = true, numbered = false;
        for (const Clause& clause : rule) {
            tags = tags || (clause.key == "TAG" && clause.op == "+=" && clause.value == "uaccess");
            const bool is_vendor = clause.key == attribute + "{idVendor}";
            if (!is_vendor && clause.key != attribute + "{idProduct}") continue;
            numbered = true;
            matches = matches && clause.op == "==" && oneOf(clause.value, hex(is_vendor ? vendor : product));
        }
        if (tags && numbered && matches) return true;
    }
    return false;
}

TEST(UdevRules, AreReadableAndSortedBeforeTheSeatsRules) {
    static const std::set<std::string> kKeys{
        "SUBSYSTEM",       "ACTION",       "GOTO",           "LABEL",           "TAG",
        "KERNELS",         "ENV{DEVTYPE}", "ATTR{idVendor}", "ATTR{idProduct}", "ATTRS{idVendor}",
        "ATTRS{idProduct}"};
    static const std::regex numbers("[0-9a-f]{4}(\\|[0-9a-f]{4})*");
    int files = 0;
    for (const auto& entry : fs::directory_iterator(folder())) {
        if (entry.path().extension() != ".rules") continue;
        ++files;
        EXPECT_LT(entry.path().filename().string(), "73-seat-late.rules");
        std::set<std::string> jumps, labels;
        for (const Rule& rule : rulesIn(entry.path()))
            for (const Clause& clause : rule) {
                EXPECT_TRUE(kKeys.contains(clause.key)) << clause.key;
                EXPECT_TRUE(!clause.key.starts_with("ATTR") || std::regex_match(clause.value, numbers))
                    << clause.value;
                if (clause.key == "GOTO") jumps.insert(clause.value);
                if (clause.key == "LABEL") labels.insert(clause.value);
            }
        EXPECT_EQ(jumps, labels) << entry.path();
    }
    EXPECT_EQ(files, 2);
}

TEST(UdevRules, GrantAccessToExactlyTheSupportedDevices) {
    const std::vector<Rule> hidraw = rulesIn(folder() / "70-stylet-hidraw.rules");
    const std::vector<Rule> usb = rulesIn(folder() / "70-stylet-usb.rules");
    EXPECT_TRUE(allows(hidraw, "ATTRS", 0x1234, 0x0006));
    EXPECT_TRUE(allows(usb, "ATTR", 0x0403, 0xcb48));
    EXPECT_TRUE(allows(usb, "ATTR", 0x1451, 0x0402));
    EXPECT_FALSE(allows(usb, "ATTR", 0x0403, 0x6001)) << "any other FTDI chip";
    EXPECT_FALSE(allows(hidraw, "ATTRS", 0x1234, 0x0007));
    for (const unsigned vendor : {0x046du, 0x256fu})
        for (unsigned product = 0xc600; product <= 0xc6ff; ++product)
            EXPECT_EQ(allows(hidraw, "ATTRS", vendor, product),
                      isSpaceMouse(std::uint16_t(vendor), std::uint16_t(product), 1, 8))
                << hex(vendor) << ":" << hex(product);
}

}  // namespace
}  // namespace stylet::haptics
