#include "world/report.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "control/control.h"
#include "scenario/json_line.h"
#include "world/assertion_checks.h"
#include "world/call.h"
#include "world/objects.h"

namespace xrmock {

namespace {

using Verdicts = std::vector<std::pair<std::string, std::string>>;  // name, reason of the failure

constexpr std::pair<char, const char*> kEntities[] = {
    {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}};

std::string escaped(const std::string& text) {
    std::string xml;
    // Application names may contain invalid UTF-8. JsonLine replaces it.
    for (const char c : nlohmann::json::parse(JsonLine().text(text).str()).get<std::string>()) {
        const auto entity = std::find_if(std::begin(kEntities), std::end(kEntities),
                                         [&](const auto& each) { return each.first == c; });
        if (entity != std::end(kEntities))
            xml += entity->second;
        else
            xml += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;  // XML has no control characters
    }
    return xml;
}

std::vector<std::pair<const char*, std::uint64_t>> listCounts(const Instance& instance) {
    const Statistics& counts = instance.statistics;
    return {{"frames submitted", counts.submitted},  {"frames discarded", counts.discarded},
            {"refreshes missed", counts.missed},     {"pictures captured", counts.captured},
            {"haptic pulses", counts.haptic_pulses}, {"calls refused", counts.refusals}};
}

std::size_t countFailures(const Verdicts& verdicts) {
    std::size_t failures = 0;
    for (const auto& [name, failure] : verdicts)
        failures += !failure.empty();
    return failures;
}

void finish(std::ofstream& out, const std::string& file) {
    out.close();
    if (!out) std::fprintf(stderr, "xrmock: XRMOCK_REPORT: %s cannot be written\n", file.c_str());
}

void writeText(const std::string& file, const Instance& instance, const Verdicts& verdicts) {
    std::ofstream out(file);
    out << instance.application << ": " << verdicts.size() << " assertions, " << countFailures(verdicts)
        << " failed\n";
    for (const auto& [name, count] : listCounts(instance))
        out << "  " << name << ": " << count << '\n';
    if (!instance.first_refusal.empty()) out << "  first refusal: " << instance.first_refusal << '\n';
    for (const auto& [name, failure] : verdicts)
        out << (failure.empty() ? "ok      " : "FAILED  ") << name << (failure.empty() ? "" : ": ") << failure
            << '\n';
    finish(out, file);
}

void writeJUnit(const std::string& file, const Instance& instance, const Verdicts& verdicts) {
    std::ofstream out(file);
    const double seconds = instance.clock.scenarioSeconds(instance.clock.now(monotonicNs()));
    const std::string counts = "tests=\"" + std::to_string(verdicts.size()) + "\" failures=\"" +
                               std::to_string(countFailures(verdicts)) + "\" errors=\"0\" time=\"" +
                               std::to_string(seconds) + "\"";
    out << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"xrmock\" " << counts << ">\n"
        << "  <testsuite name=\"" << escaped(instance.application) << "\" " << counts
        << " skipped=\"0\">\n    <properties>\n";
    for (const auto& [name, count] : listCounts(instance))
        out << "      <property name=\"" << name << "\" value=\"" << count << "\"/>\n";
    out << "    </properties>\n";
    for (const auto& [name, failure] : verdicts) {
        out << "    <testcase classname=\"scenario\" name=\"" << escaped(name) << "\" time=\"0\"";
        if (failure.empty()) {
            out << "/>\n";
        } else {
            const std::string text = escaped(failure);
            out << ">\n      <failure type=\"assertion\" message=\"" << text << "\">" << text
                << "</failure>\n    </testcase>\n";
        }
    }
    out << "  </testsuite>\n</testsuites>\n";
    finish(out, file);
}

// Reports the instances that are alive when the process ends.
void reportRemaining() {
    for (int i = 0; !runtime().mutex.try_lock(); ++i) {
        if (i == 100) return;  // after a second: a thread is stuck inside a call
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    if (runtime().log) runtime().log->flush();
    for (const Instance* instance : runtime().reported) {
        writeReport(*instance);
        if (instance->control) ::unlink(instance->control->path().c_str());
    }
    runtime().reported.clear();
    runtime().mutex.unlock();
}

}  // namespace

void writeReport(const Instance& instance) {
    Verdicts verdicts;
    for (const Assertion& assertion : instance.scenario.assertions) {
        verdicts.emplace_back(assertion.name, evaluateAssertion(assertion, instance));
        if (verdicts.back().second.empty()) continue;
        std::fprintf(stderr, "xrmock: FAILED %s: %s\n", verdicts.back().first.c_str(),
                     verdicts.back().second.c_str());
    }
    const char* stem = std::getenv("XRMOCK_REPORT");
    if (stem == nullptr || *stem == '\0') return;
    // Later instances of the process get their own files.
    const std::uint64_t number = ++runtime().reports;
    const std::string file = number == 1 ? stem : std::string(stem) + "." + std::to_string(number);
    writeText(file + ".txt", instance, verdicts);
    writeJUnit(file + ".xml", instance, verdicts);
}

void reportAtExit() {
    static const int once = std::atexit(reportRemaining);
    static_cast<void>(once);
}

}  // namespace xrmock
