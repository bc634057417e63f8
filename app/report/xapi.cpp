#include "app/report/xapi.h"

#include <fmt/core.h>

#include <boost/uuid/name_generator_sha1.hpp>
#include <boost/uuid/uuid.hpp>
#include <boost/uuid/uuid_io.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/report/page.h"
#include "app/report/verdict.h"
#include "patient/patient.h"

namespace stylet::report {

using nlohmann::json;

namespace {

constexpr const char* kVerbs = "http://adlnet.gov/expapi/verbs/";

std::string nameUuid(const std::string& name) {
    return boost::uuids::to_string(boost::uuids::name_generator_sha1(boost::uuids::ns::url())(name));
}

// Percent-encodes a segment of an address. Keeps the unreserved characters of RFC 3986.
std::string percentEncoded(const std::string& text) {
    static constexpr std::string_view kDigits = "0123456789ABCDEF";
    std::string out;
    for (const char c : plainText(text)) {
        const auto byte = static_cast<unsigned char>(c);
        if ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
            std::string_view("-._~").find(c) != std::string_view::npos)
            out += c;
        else
            out += {'%', kDigits[byte >> 4], kDigits[byte & 15u]};
    }
    return out.empty() ? "unnamed" : out;
}

void checkHome(const std::string& home) {
    const bool web = home.starts_with("https://") || home.starts_with("http://");
    const std::size_t host = home.find("//") + 2;
    bool clean = web && home.size() > host && home[host] != '/' && !home.ends_with('/');
    for (const char c : home)
        clean = clean && static_cast<unsigned char>(c) > 0x20 && static_cast<unsigned char>(c) < 0x7F &&
                std::string_view("<>\"{}|\\^`").find(c) == std::string_view::npos;
    if (!clean)
        throw DataError("xAPI", "home",
                        "\"" + home + "\" is no http or https address without a slash at its end");
}

// Returns `started` ("2026-11-21T20:15:00.123Z") plus `seconds`, or nothing if the text is not such a time.
std::optional<std::string> timeAfter(const std::string& started, double seconds) {
    namespace chrono = std::chrono;
    int year = 0, month = 0, day = 0, hour = 0, minute = 0, used = 0;
    double second = 0.0;
    if (std::sscanf(started.c_str(), "%4d-%2d-%2dT%2d:%2d:%lfZ%n", &year, &month, &day, &hour, &minute,
                    &second, &used) != 6 ||
        std::size_t(used) != started.size())
        return std::nullopt;
    const chrono::year_month_day date{chrono::year(year), chrono::month(unsigned(month)),
                                      chrono::day(unsigned(day))};
    if (!date.ok() || hour < 0 || hour > 23 || minute < 0 || minute > 59 ||
        !(second >= 0.0 && second < 61.0) || !(seconds >= 0.0 && seconds < 1e8))
        return std::nullopt;
    const auto then = chrono::sys_days(date) + chrono::hours(hour) + chrono::minutes(minute) +
                      chrono::milliseconds(std::llround(1e3 * (second + seconds)));
    const auto on = chrono::floor<chrono::days>(then);
    const chrono::year_month_day d(on);
    const chrono::hh_mm_ss t(chrono::floor<chrono::milliseconds>(then - on));
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", int(d.year()), unsigned(d.month()),
                       unsigned(d.day()), t.hours().count(), t.minutes().count(), t.seconds().count(),
                       t.subseconds().count());
}

// Adds a statement with the parts that all statements of an attempt share, and returns it.
json& addStatement(json& list, const records::StoredAttempt& attempt, const std::string& home,
                   const std::string& verb, double after_s) {
    const std::string scenario = plainText(attempt.info.scenario);
    json s = {{"id", nameUuid(home + "/attempts/" + percentEncoded(attempt.id) + "/" + verb)},
              {"actor",
               {{"objectType", "Agent"},
                {"account", {{"homePage", home}, {"name", plainText(attempt.info.trainee)}}}}},
              {"verb", {{"id", kVerbs + verb}, {"display", {{"en", verb}}}}},
              {"object",
               {{"objectType", "Activity"},
                {"id", home + "/scenarios/" + percentEncoded(attempt.info.scenario)},
                {"definition",
                 {{"type", "http://adlnet.gov/expapi/activities/simulation"},
                  {"name", {{"en", "PTCD: " + (scenario.empty() ? "unnamed scenario" : scenario)}}},
                  {"description", {{"en", "Simulated percutaneous transhepatic cholangio-drainage"}}}}}}},
              {"context",
               {{"registration", nameUuid(home + "/attempts/" + percentEncoded(attempt.id))},
                {"platform", "Stylet " + plainText(attempt.info.program_version)},
                {"extensions",
                 {{home + "/xapi/seed", std::to_string(attempt.info.seed)},
                  {home + "/xapi/difficulty", plainText(attempt.info.difficulty)},
                  {home + "/xapi/device", plainText(attempt.info.device)}}}}}};
    if (const auto at = timeAfter(attempt.started_utc, after_s)) s["timestamp"] = *at;
    list.push_back(std::move(s));
    return list.back();
}

double attemptDuration_s(const records::StoredAttempt& attempt) {
    if (attempt.result) return double(attempt.result->ticks) * attempt.info.dt_s;
    std::uint64_t last = 0;
    for (const records::EventRow& event : attempt.events)
        last = std::max(last, event.tick);
    return double(last) * attempt.info.dt_s;
}

json metricsJson(const records::AttemptResult& result) {
    json metrics = json::object();
    for (const records::MetricRow& m : result.metrics) {
        json& metric = metrics[plainText(m.id)] = {
            {"unit", plainText(m.unit)}, {"points", m.points}, {"mostPoints", m.max_points}};
        if (std::isfinite(m.value)) metric["value"] = m.value;  // JSON has no infinity
    }
    return metrics;
}

void addAttempt(const records::StoredAttempt& attempt, const XapiSettings& settings, json& list) {
    const auto add = [&](const char* verb, double after_s) -> json& {
        return addStatement(list, attempt, settings.home, verb, after_s);
    };
    const double seconds = attemptDuration_s(attempt);
    const std::string duration = isoDuration(seconds);
    add("initialized", 0.0);
    if (attempt.state == records::AttemptState::running) return;
    if (records::countsInStatistics(attempt)) {
        const records::AttemptResult& result = *attempt.result;
        add("completed", seconds)["result"] = {{"completion", true}, {"duration", duration}};
        const double total = std::isfinite(result.total) ? std::min(std::max(result.total, 0.0), 100.0) : 0.0;
        const bool success = passed(attempt);
        add(success ? "passed" : "failed", seconds)["result"] = {
            {"success", success},
            {"score", {{"scaled", total / 100.0}, {"raw", total}, {"min", 0}, {"max", 100}}},
            {"duration", duration},
            {"extensions", {{settings.home + "/xapi/metrics", metricsJson(result)}}}};
        add("terminated", seconds)["result"] = {{"duration", duration}};
    } else if (attempt.result && !attempt.result->aborted) {  // restarted or imported
        add("completed", seconds)["result"] = {{"completion", true}, {"duration", duration}};
        add("terminated", seconds)["result"] = {{"duration", duration}};
    } else {
        if (records::isUnfinishedExam(attempt))
            add("failed", seconds)["result"] = {
                {"success", false}, {"completion", false}, {"duration", duration}};
        add("terminated", seconds)["result"] = {{"completion", false}, {"duration", duration}};
    }
}

}  // namespace

std::string isoDuration(double seconds) {
    if (!(seconds >= 0.0) || seconds > 1e9) seconds = 0.0;
    const auto hundredths = std::llround(100.0 * seconds);
    const long long hours = hundredths / 360000, minutes = hundredths / 6000 % 60, rest = hundredths % 6000;
    std::string text = "PT";
    if (hours > 0) text += fmt::format("{}H", hours);
    if (minutes > 0) text += fmt::format("{}M", minutes);
    if (rest % 100 > 0) return text + fmt::format("{}.{:02}S", rest / 100, rest % 100);
    if (rest > 0 || text == "PT") text += fmt::format("{}S", rest / 100);
    return text;
}

std::string xapiStatements(const std::vector<records::StoredAttempt>& attempts,
                           const XapiSettings& settings) {
    checkHome(settings.home);
    json list = json::array();
    for (const records::StoredAttempt& attempt : attempts)
        if (!attempt.info.trainee.empty()) addAttempt(attempt, settings, list);
    return list.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace stylet::report
