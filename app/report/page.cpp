#include "app/report/page.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "app/report/embedded.h"
#include "base/csv.h"
#include "base/utf8.h"
#include "base/whole_file.h"
#include "patient/patient.h"

namespace stylet::report {

namespace {

constexpr std::size_t kShort = 20;  // shorter cells stay on one line of a table
constexpr std::string_view kReplacement = "\xEF\xBF\xBD";

std::vector<std::uint8_t> decodeHex(std::string_view hex) {
    const auto digit = [](char c) { return unsigned(c <= '9' ? c - '0' : c - 'a' + 10); };
    std::vector<std::uint8_t> bytes;
    for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
        bytes.push_back(std::uint8_t(16u * digit(hex[i]) + digit(hex[i + 1])));
    return bytes;
}

std::string scriptDigest(const Embedded& file) {
    return "'sha256-" + base64(decodeHex(file.sha256)) + "'";
}

bool numeric(const Table& table, std::size_t column) {
    return column < table.number.size() && table.number[column];
}

std::string tableHtml(const Table& table) {
    std::string html = fmt::format(
        "<div class=\"table\" role=\"region\" tabindex=\"0\" aria-label=\"{0}\"><table{1}>\n"
        "<caption>{0}</caption>\n<thead><tr>",
        escaped(table.caption), table.sortable ? " class=\"sortable\"" : "");
    for (std::size_t c = 0; c < table.head.size(); ++c)
        html += fmt::format("<th scope=\"col\"{}>{}</th>", numeric(table, c) ? " class=\"n\"" : "",
                            escaped(table.head[c]));
    html += "</tr></thead>\n<tbody>\n";
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
        const std::vector<std::string>& row = table.rows[r];
        html += r < table.row_ids.size() ? fmt::format("<tr id=\"{}\">", escaped(table.row_ids[r])) : "<tr>";
        for (std::size_t c = 0; c < row.size(); ++c) {
            const bool number = numeric(table, c);
            const char* const sort = !number          ? ""
                                     : row[c] == "∞"  ? " data-sort=\"Infinity\""
                                     : row[c] == "-∞" ? " data-sort=\"-Infinity\""
                                                      : "";
            const char* const classes = number                    ? " class=\"n\""
                                        : row[c].size() <= kShort ? " class=\"s\""
                                                                  : "";
            html += fmt::format("<{0}{1}{2}{3}>{4}</{0}>", c == 0 ? "th" : "td",
                                c == 0 ? " scope=\"row\"" : "", sort, classes, escaped(row[c]));
        }
        html += "</tr>\n";
    }
    return html + "</tbody></table></div>\n";
}

// `attributes`: begins with a space or is empty.
std::string pictureHtml(const Picture& picture, std::string_view attributes) {
    return fmt::format("<img{} width=\"{}\" height=\"{}\" alt=\"{}\" src=\"data:{};base64,{}\">", attributes,
                       picture.width, picture.height, escaped(picture.alt), picture.type,
                       base64(picture.bytes));
}

// U+202A to U+202E and U+2066 to U+2069, as UTF-8.
bool isDirectionControl(std::string_view character) {
    return (character >= "\xE2\x80\xAA" && character <= "\xE2\x80\xAE") ||
           (character >= "\xE2\x81\xA6" && character <= "\xE2\x81\xA9");
}

}  // namespace

std::string plainText(std::string_view bytes) {
    std::string text;
    for (std::size_t i = 0; i < bytes.size();) {
        const std::size_t length = utf8Length(bytes.substr(i));
        const auto c = static_cast<unsigned char>(bytes[i]);
        const bool control = (c < 0x20 && c != '\n' && c != '\t') || c == 0x7F;
        if (length == 0 || control)
            text += kReplacement, ++i;
        else if (isDirectionControl(bytes.substr(i, length)))
            text += kReplacement, i += length;
        else
            text += bytes.substr(i, length), i += length;
    }
    return text;
}

std::string escaped(std::string_view bytes) {
    constexpr std::string_view kSpecial = "&<>\"'";
    constexpr std::array<std::string_view, 5> kEntities{"&amp;", "&lt;", "&gt;", "&quot;", "&#39;"};
    std::string html;
    for (const char c : plainText(bytes))
        if (const std::size_t i = kSpecial.find(c); i != std::string_view::npos)
            html += kEntities[i];
        else
            html += c;
    return html;
}

std::string base64(std::span<const std::uint8_t> bytes) {
    static constexpr std::string_view kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const auto at = [&](std::size_t k) { return i + k < bytes.size() ? unsigned(bytes[i + k]) : 0u; };
        const unsigned three = at(0) << 16 | at(1) << 8 | at(2);
        text += kDigits[three >> 18];
        text += kDigits[three >> 12 & 63u];
        text += i + 1 < bytes.size() ? kDigits[three >> 6 & 63u] : '=';
        text += i + 2 < bytes.size() ? kDigits[three & 63u] : '=';
    }
    return text;
}

std::string fixed(double value, int digits) {
    if (std::isnan(value)) return "–";
    if (std::isinf(value)) return value > 0 ? "∞" : "-∞";
    std::string out = fmt::format("{:.{}f}", value, digits);
    if (out[0] == '-' && out.find_first_of("123456789") == std::string::npos) out.erase(0, 1);
    return out;
}

std::string clockText(double seconds) {
    if (!(seconds >= 0.0) || seconds > 1e9) return "–";
    const auto tenths = std::llround(10.0 * seconds);
    return fmt::format("{}:{:02}.{}", tenths / 600, tenths / 10 % 60, tenths % 10);
}

Page::Page(const std::string& title, const std::string& lead, const std::string& maker)
    : title_(escaped(title)),
      maker_(escaped(maker)),
      body_("<h1>" + title_ + "</h1>\n<p class=\"lead\">" + escaped(lead) + "</p>\n"),
      navigation_at_(body_.size()) {}

void Page::headlines(const std::vector<Headline>& all) {
    body_ += "<ul class=\"figures\">";
    for (const Headline& h : all)
        body_ += fmt::format("<li><b>{}</b><span>{}</span></li>", escaped(h.value), escaped(h.name));
    body_ += "</ul>\n";
    navigation_at_ = body_.size();
}

void Page::section(const std::string& title) {
    ++sections_;
    body_ += fmt::format("<h2 id=\"section-{}\">{}</h2>\n", sections_, escaped(title));
    navigation_ += fmt::format("<li><a href=\"#section-{}\">{}</a></li>", sections_, escaped(title));
}

void Page::paragraph(const std::string& text) {
    body_ += "<p>" + escaped(text) + "</p>\n";
}

void Page::advice(std::size_t number, const std::string& text, const std::string& link,
                  const std::string& row_id) {
    body_ += fmt::format("<p class=\"advice\"><b>{}.</b> {} <a href=\"#{}\">{}</a></p>\n", number,
                         escaped(text), escaped(row_id), escaped(link));
}

bool Page::mentions(std::string_view term) const {
    const auto same = [](char a, char b) {
        return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
    };
    return std::search(body_.begin(), body_.end(), term.begin(), term.end(), same) != body_.end();
}

void Page::facts(const std::vector<Fact>& all) {
    body_ += "<dl>";
    for (const Fact& fact : all)
        body_ += fmt::format("<dt>{}</dt><dd>{}</dd>\n", escaped(fact.name), escaped(fact.value));
    body_ += "</dl>\n";
}

void Page::table(const Table& table) {
    body_ += tableHtml(table);
}

void Page::collapsibleTable(const Table& table) {
    body_ += fmt::format("<details><summary>{}</summary>\n{}</details>\n", escaped(table.caption),
                         tableHtml(table));
}

void Page::figure(const DescribedFigure& f) {
    const std::string id = fmt::format("figure-{}", ++figures_);
    body_ += "<figure>";
    if (!f.figure.choices.empty()) {
        // Hidden until the script that handles it runs.
        body_ += fmt::format("<label hidden>Shown: <select id=\"{}-choice\">", id);
        for (const FigureChoice& choice : f.figure.choices)
            body_ += "<option>" + escaped(choice.name) + "</option>";
        body_ += "</select></label>\n";
    }
    body_ += fmt::format(
        "<div class=\"chart{0}\"><canvas id=\"{1}\" role=\"img\" aria-label=\"{2}\"></canvas></div>\n"
        "<noscript><p class=\"none\">The figure needs JavaScript; its numbers are in the table "
        "below.</p></noscript>\n<script class=\"figure\" type=\"application/json\" "
        "data-for=\"{1}\">{3}</script>\n"
        "<figcaption>{4}</figcaption>\n<details><summary>Numbers of this figure: {5}</summary>\n"
        "{6}</details></figure>\n",
        f.figure.low ? " low" : "", id, escaped(f.description), figureJson(f.figure), escaped(f.caption),
        escaped(f.data.caption), tableHtml(f.data));
}

void Page::picture(const Picture& picture) {
    body_ += fmt::format(
        "<figure><div class=\"picture\" role=\"region\" tabindex=\"0\" "
        "aria-label=\"{0}\">{1}</div><figcaption>{0}</figcaption></figure>\n",
        escaped(picture.caption), pictureHtml(picture, " class=\"wide\""));
}

void Page::stills(const std::vector<Picture>& all) {
    body_ += "<div class=\"stills\">\n";
    for (const Picture& picture : all)
        body_ += fmt::format("<figure>{}<figcaption>{}</figcaption></figure>\n", pictureHtml(picture, ""),
                             escaped(picture.caption));
    body_ += "</div>\n";
}

std::string Page::html() const {
    std::string html = fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
        "{}; script-src {} {}; base-uri 'none'; form-action 'none'\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<title>{}</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>{}</style>\n</head>\n"
        "<body>\n<a class=\"skip\" href=\"#main\">Skip to the content</a>\n<main id=\"main\">\n"
        "{}<nav aria-label=\"Sections\"><ul>{}</ul></nav>\n{}</main>\n<footer><p>Made by {} {}. Stylet is a "
        "training simulator, not a medical device. This file needs no network: everything it shows is inside "
        "it.</p></footer>\n",
        scriptDigest(pageCss()), scriptDigest(chartJs()), scriptDigest(pageJs()), title_, pageCss().text,
        std::string_view(body_).substr(0, navigation_at_), navigation_,
        std::string_view(body_).substr(navigation_at_), maker_, STYLET_VERSION);
    if (figures_ > 0 || body_.find("class=\"sortable\"") != std::string::npos)
        html += fmt::format("<script>{}</script>\n<script>{}</script>\n", chartJs().text, pageJs().text);
    return html + "</body>\n</html>\n";
}

void writeCsv(const Table& table, const std::filesystem::path& file) {
    std::string text;
    const auto add = [&](std::vector<std::string> row) {
        for (std::string& cell : row)
            cell = plainText(cell);
        text += csvRow(row) + '\n';
    };
    add(table.head);
    for (const std::vector<std::string>& row : table.rows)
        add(row);
    writeWholeFile(file, text);
}

}  // namespace stylet::report
