#include "scenario/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

namespace xrmock {

namespace {

// Removes the first line from `text`, with its line break, and returns it.
std::string_view popLine(std::string_view& text) {
    std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
}

// Returns false unless the line has exactly numbers.size() numbers, all within range.
bool readNumbers(std::string_view line, std::vector<double>& numbers) {
    const char* at = line.data();
    const char* const end = at + line.size();
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (i > 0 && (at == end || *at++ != ',')) return false;
        const auto [next, error] = std::from_chars(at, end, numbers[i]);
        if (error != std::errc() || !(std::abs(numbers[i]) <= kMaxNumber)) return false;
        at = next;
    }
    return at == end;
}

}  // namespace

void readCsv(const Field& field, const std::string& folder, const std::string& heading, const CsvRow& row) {
    const std::string name = field.text();
    const std::string text =
        readTextFile(name.starts_with('/') || folder.empty() ? name : folder + "/" + name);
    std::size_t line_number = 1;
    const auto fail = [&](const char* reason) {
        field.fail(name + " line " + std::to_string(line_number) + ": " + reason);
    };
    std::string_view rest = text;
    if (popLine(rest) != heading) fail("the heading is not the one expected");
    std::vector<double> numbers(static_cast<std::size_t>(std::count(heading.begin(), heading.end(), ',')) +
                                1);
    double previous_s = -1;
    while (!rest.empty()) {
        if (++line_number > kMaxElements) fail("too many lines");
        if (!readNumbers(popLine(rest), numbers)) fail("as many numbers as the heading has names expected");
        if (numbers[0] < 0 || numbers[0] <= previous_s) fail("later than the line before expected");
        previous_s = numbers[0];
        row(numbers, fail);
    }
    if (line_number == 1) fail("at least one line below the heading expected");
}

}  // namespace xrmock
