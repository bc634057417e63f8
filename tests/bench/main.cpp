#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "tests/bench/bench.h"

namespace stylet::bench {
namespace {

bool long_run = false;

std::vector<std::pair<std::string, Bench>>& registry() {
    static std::vector<std::pair<std::string, Bench>> benches;
    return benches;
}

void print(const Row& r) {
    std::printf("%-40s %-20s %10.4g %12.4g ms %12.4g %-10s  %s\n", r.name.c_str(), r.knob.c_str(), r.value,
                r.time_ms, r.error, r.error_unit.c_str(), r.reference.c_str());
    if (!r.note.empty()) std::printf("%-40s   %s\n", "", r.note.c_str());
    std::fflush(stdout);
}

// Replaces the rows of the file whose names occur in `rows`. The other rows stay.
void mergeInto(const std::string& path, const std::vector<Row>& rows) {
    std::set<std::string> measured;
    for (const Row& r : rows)
        measured.insert(r.name);
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    if (std::ifstream earlier(path); earlier)
        for (const nlohmann::ordered_json& row : nlohmann::ordered_json::parse(earlier))
            if (!measured.contains(row.at("name").get<std::string>())) list.push_back(row);
    for (const Row& r : rows) {
        list.push_back({{"name", r.name},
                        {"knob", r.knob},
                        {"value", r.value},
                        {"time_ms", r.time_ms},
                        {"error", r.error},
                        {"error_unit", r.error_unit},
                        {"reference", r.reference},
                        {"note", r.note}});
    }
    std::ofstream file(path);
    file << list.dump(2) << '\n';
    if (!file.flush()) throw std::runtime_error(path + ": cannot be written");
}

int run(std::string_view only, const std::string& out) {
    std::sort(registry().begin(), registry().end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<Row> rows;
    bool any = false;
    for (const auto& [name, bench] : registry()) {
        if (!name.starts_with(only)) continue;
        any = true;
        std::printf("# %s\n", name.c_str());
        const std::size_t first = rows.size();
        bench(rows);
        for (std::size_t i = first; i < rows.size(); ++i)
            print(rows[i]);
    }
    if (!any) {
        std::fprintf(stderr,
                     "stylet-bench: no bench begins with '%s'; there are:", std::string(only).c_str());
        for (const auto& entry : registry())
            std::fprintf(stderr, " %s", entry.first.c_str());
        std::fprintf(stderr, "\n");
        return 1;
    }
    if (only.empty()) std::filesystem::remove(out);  // all rows were measured: discard the old file
    if (!out.empty()) mergeInto(out, rows);
    return 0;
}

}  // namespace

Registration::Registration(const char* name, Bench bench) {
    registry().emplace_back(name, bench);
}

bool isLongRun() {
    return long_run;
}
void setLongRun(bool on) {
    long_run = on;
}

}  // namespace stylet::bench

int main(int argc, char** argv) {
    std::string only, out;
    bool is_long = false;
    for (int i = 1; i < argc; ++i) {
        const std::string_view option = argv[i];
        if (i + 1 < argc && option == "--only") {
            only = argv[++i];
        } else if (i + 1 < argc && option == "--out") {
            out = argv[++i];
        } else if (option == "--long") {
            is_long = true;
        } else {
            std::fprintf(stderr, "usage: stylet-bench [--only PREFIX] [--long] [--out FILE.json]\n");
            return 2;
        }
    }
    stylet::bench::setLongRun(is_long);
    try {
        return stylet::bench::run(only, out);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "stylet-bench: %s\n", e.what());
        return 1;
    }
}
