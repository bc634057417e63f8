#include "app/training/difficulty.h"

#include "base/fields.h"
#include "base/whole_file.h"

namespace stylet::training {

namespace {

constexpr std::size_t kMaxTableBytes = 1 << 14;

struct Flag {
    const char* name;
    bool DifficultyRules::* value;
};
constexpr std::array kFlags{
    Flag{"panel", &DifficultyRules::panel},         Flag{"next_step", &DifficultyRules::next_step},
    Flag{"path", &DifficultyRules::path},           Flag{"colours", &DifficultyRules::colours},
    Flag{"cues", &DifficultyRules::cues},           Flag{"slices", &DifficultyRules::slices},
    Flag{"open_look", &DifficultyRules::open_look}, Flag{"home", &DifficultyRules::home},
    Flag{"snap", &DifficultyRules::snap},           Flag{"expert", &DifficultyRules::expert}};

DifficultyRules readRules(Fields in, const DifficultyRules* easier) {
    DifficultyRules rules;
    for (const Flag& flag : kFlags) {
        rules.*flag.value = in.flag(flag.name);
        if (easier && rules.*flag.value && !(easier->*flag.value))
            in.refuse(flag.name, "an easier difficulty forbids it");
    }
    rules.start = in.choice<StartPlace>("start", kStartPlaceNames);
    if (easier && rules.start < easier->start) in.refuse("start", "an easier difficulty begins elsewhere");
    if (rules.next_step && !rules.panel) in.refuse("next_step", "needs the panel");
    in.finish();
    return rules;
}

}  // namespace

DifficultyTable loadDifficulties(const std::filesystem::path& toml) {
    return parseDifficulties(readWholeFile(toml, kMaxTableBytes), toml);
}

DifficultyTable parseDifficulties(std::string_view toml, const std::filesystem::path& file) {
    Fields top = parseToml(file, toml);
    DifficultyTable table;
    const DifficultyRules* easier = nullptr;
    for (int i = 0; i < kDifficultyCount; ++i) {
        table[Difficulty(i)] = readRules(top.child(difficultyName(Difficulty(i))), easier);
        easier = &table[Difficulty(i)];
    }
    top.finish();
    return table;
}

}  // namespace stylet::training
