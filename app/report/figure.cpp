#include "app/report/figure.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/report/page.h"
#include "base/hex.h"
#include "base/text.h"

namespace stylet::report {

using nlohmann::json;

namespace {

// Five digits are more than a screen shows. For a thousand numbers, each omitted digit saves a kilobyte.
json numberJson(double value) {
    if (!std::isfinite(value)) return nullptr;
    const double rounded = parseNumber<double>(fmt::format("{:.5g}", value)).value_or(kGap);
    if (rounded == std::floor(rounded) && std::fabs(rounded) < 1e15) return std::int64_t(rounded);
    return rounded;
}

json textsJson(const std::vector<std::string>& texts) {
    json list = json::array();
    for (const std::string& text : texts)
        list.push_back(plainText(text));
    return list;
}

json axisJson(const FigureAxis& axis) {
    json j = {{"title", plainText(axis.title)}};
    if (axis.min) j["min"] = *axis.min;
    if (axis.max) j["max"] = *axis.max;
    if (!axis.names.empty()) j["names"] = textsJson(axis.names);
    if (axis.whole) j["whole"] = true;
    return j;
}

json pointJson(const FigurePoint& p) {
    json j = json::array({numberJson(p.x), numberJson(p.y)});
    if (!p.text.empty()) j.push_back(plainText(p.text));
    return j;
}

json seriesJson(const std::vector<FigureSeries>& all) {
    json list = json::array();
    for (const FigureSeries& s : all) {
        json points = json::array();
        for (const FigurePoint& p : s.points)
            points.push_back(pointJson(p));
        list.push_back({{"name", plainText(s.name)},
                        {"colour", hexColour(s.colour)},
                        {"points", std::move(points)},
                        {"line", s.line},
                        {"dash", s.dash},
                        {"width", s.width}});
        if (!s.shape.empty()) list.back()["shape"] = s.shape;
        if (s.small) list.back()["small"] = true;
    }
    return list;
}

}  // namespace

std::string hexColour(const Colour& c) {
    const auto byte = [](double v) { return unsigned(std::lround(255.0 * std::clamp(v, 0.0, 1.0))); };
    return "#" + hexText(byte(c.r), 2) + hexText(byte(c.g), 2) + hexText(byte(c.b), 2);
}

std::string figureJson(const Figure& figure) {
    json j = {{"x", axisJson(figure.x)}, {"y", axisJson(figure.y)}, {"series", seriesJson(figure.series)}};
    for (const FigureBand& b : figure.bands)
        j["bands"].push_back({{"from", numberJson(b.from)},
                              {"to", numberJson(b.to)},
                              {"text", plainText(b.text)},
                              {"colour", hexColour(b.colour)}});
    for (const FigureSpan& s : figure.spans)
        j["spans"].push_back({{"lane", s.lane},
                              {"from", numberJson(s.from)},
                              {"to", numberJson(s.to)},
                              {"text", plainText(s.text)},
                              {"colour", hexColour(s.colour)}});
    for (const FigureBox& b : figure.boxes)
        j["boxes"].push_back({{"x", numberJson(b.x)},
                              {"low", numberJson(b.low)},
                              {"lower", numberJson(b.lower_quartile)},
                              {"median", numberJson(b.median)},
                              {"upper", numberJson(b.upper_quartile)},
                              {"high", numberJson(b.high)},
                              {"colour", hexColour(b.colour)}});
    for (const FigureLine& line : figure.lines)
        j["lines"].push_back({{"y", numberJson(line.y)}, {"text", plainText(line.text)}});
    for (const FigurePoint& mark : figure.marks)
        j["marks"].push_back(
            {{"x", numberJson(mark.x)}, {"y", numberJson(mark.y)}, {"text", plainText(mark.text)}});
    for (const FigureChoice& choice : figure.choices)
        j["choices"].push_back({{"name", plainText(choice.name)},
                                {"y", axisJson(choice.y)},
                                {"series", seriesJson(choice.series)}});
    const std::string text = j.dump(-1, ' ', false, json::error_handler_t::replace);
    std::string safe;
    safe.reserve(text.size());
    for (const char c : text)  // <, > and & occur in JSON only inside strings
        if (c == '<' || c == '>' || c == '&')
            safe += "\\u" + hexText(std::uint64_t(c), 4);
        else
            safe += c;
    return safe;
}

std::vector<FigurePoint> downsample(const std::vector<FigurePoint>& points, std::size_t buckets) {
    if (buckets == 0 || points.size() <= 4 * buckets) return points;
    std::vector<FigurePoint> kept;
    const auto size = double(points.size()) / double(buckets);
    for (std::size_t b = 0; b < buckets; ++b) {
        const auto begin = std::size_t(double(b) * size);
        const std::size_t end = b + 1 == buckets ? points.size() : std::size_t(double(b + 1) * size);
        std::size_t low = begin, high = begin, gap = end;
        for (std::size_t i = begin; i < end; ++i) {
            if (std::isnan(points[i].y)) {
                gap = std::min(gap, i);
                continue;
            }
            if (std::isnan(points[low].y) || points[i].y < points[low].y) low = i;
            if (std::isnan(points[high].y) || points[i].y > points[high].y) high = i;
        }
        std::array<std::size_t, 5> chosen{begin, low, high, gap, end - 1};
        std::sort(chosen.begin(), chosen.end());
        for (std::size_t i = 0; i < chosen.size(); ++i)
            if (chosen[i] < end && (i == 0 || chosen[i] != chosen[i - 1])) kept.push_back(points[chosen[i]]);
    }
    return kept;
}

}  // namespace stylet::report
