#include "app/report/glossary.h"

#include <algorithm>
#include <iterator>
#include <string_view>

#include "app/report/embedded.h"
#include "base/text.h"

namespace stylet::report {

namespace {

// Reads the rows "| term | meaning |" of the page's table, below its head and its line of dashes.
std::vector<Fact> parseGlossary(std::string_view page) {
    std::vector<Fact> terms;
    int row = 0;
    while (!page.empty()) {
        const std::size_t end = std::min(page.find('\n'), page.size());
        const std::string_view line = page.substr(0, end);
        page.remove_prefix(std::min(end + 1, page.size()));
        const std::size_t middle = line.find('|', 1), last = line.rfind('|');
        if (!line.starts_with('|') || middle >= last || ++row <= 2) continue;
        terms.push_back({std::string(trimmed(line.substr(1, middle - 1))),
                         std::string(trimmed(line.substr(middle + 1, last - middle - 1)))});
    }
    return terms;
}

}  // namespace

const std::vector<Fact>& glossary() {
    static const std::vector<Fact> terms = parseGlossary(glossaryMd().text);
    return terms;
}

void addGlossary(Page& page) {
    std::vector<Fact> used;
    std::copy_if(glossary().begin(), glossary().end(), std::back_inserter(used),
                 [&](const Fact& term) { return page.mentions(term.name); });
    if (used.empty()) return;
    page.section("Glossary");
    page.facts(used);
}

}  // namespace stylet::report
