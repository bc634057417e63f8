#include "patient/package/package_toml.h"
#include "tests/fuzz/parser_target.h"

// The result is a package or a DataError. An accepted package has consistent roles and survives a write and
// parse round trip. HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    using namespace stylet::patient;
    if (input.size() > kMaxTomlBytes) return;  // rejected before parsing
    const Package p = parsePackageToml("fuzz.toml", input);
    for (const Label& label : p.label_table)
        if (findRoleConflict(label)) std::abort();
    const std::string text = packageToml(p);
    if (packageToml(parsePackageToml("fuzz.toml", text)) != text) std::abort();
}
