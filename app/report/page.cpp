#include "app/report/page.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "app/report/embedded.h"
#include "base/whole_file.h"
#include "patient/patient.h"

namespace stylet::report {

namespace {

constexpr std::size_t kShort = 20;  // shorter cells stay on one line of a table
constexpr std::string_view kReplacement = "\xEF\xBF\xBD";

// Length of the well-formed UTF-8 character at the start of `s`, or 0 if there is none.
std::size_t characterAt(std::string_view s) {
    const auto byte = [&](std::size_t i) {
        return i < s.size() ? unsigned(static_cast<unsigned char>(s[i])) : 0u;
    };
    const auto tail = [&](std::size_t i) { return (byte(i) & 0xC0u) == 0x80u; };
    const unsigned a = byte(0), b = byte(1);
    if (a < 0x80u) return 1;
    if (a >= 0xC2u && a <= 0xDFu) return tail(1) ? 2 : 0;
    if (a >= 0xE0u && a <= 0xEFu) {
        const bool overlong = a == 0xE0u && b < 0xA0u, surrogate = a == 0xEDu && b >= 0xA0u;
        return tail(1) && tail(2) && !overlong && !surrogate ? 3 : 0;
    }
    if (a >= 0xF0u && a <= 0xF4u) {
        const bool overlong = a == 0xF0u && b < 0x90u, beyond = a == 0xF4u && b >= 0x90u;
        return tail(1) && tail(2) && tail(3) && !overlong && !beyond ? 4 : 0;
    }
    return 0;
}

std::vector<std::uint8_t> bytesOfHex(std::string_view hex) {
    const auto digit = [](char c) { return unsigned(c <= '9' ? c - '0' : c - 'a' + 10); };
    std::vector<std::uint8_t> bytes;
    for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
        bytes.push_back(std::uint8_t(16u * digit(hex[i]) + digit(hex[i + 1])));
    return bytes;
}

std::string digestOf(const Embedded& file) {
    return "'sha256-" + base64(bytesOfHex(file.sha256)) + "'";
}

bool numeric(const Table& table, std::size_t column) {
    return column < table.number.size() && table.number[column];
}

std::string tableHtml(const Table& table) {
    std::string html = "<div class=\"table\" role=\"region\" tabindex=\"0\" aria-label=\"" +
                       escaped(table.caption) + "\"><table" + (table.sortable ? " class=\"sortable\"" : "") +
                       ">\n<caption>" + escaped(table.caption) + "</caption>\n<thead><tr>";
    for (std::size_t c = 0; c < table.head.size(); ++c)
        html += std::string("<th scope=\"col\"") + (numeric(table, c) ? " class=\"n\">" : ">") +
                escaped(table.head[c]) + "</th>";
    html += "</tr></thead>\n<tbody>\n";
    for (const std::vector<std::string>& row : table.rows) {
        html += "<tr>";
        for (std::size_t c = 0; c < row.size(); ++c) {
            const std::string kind = c == 0 ? "th" : "td";
            const bool number = numeric(table, c);
            const char* const sort = !number          ? ""
                                     : row[c] == "∞"  ? " data-sort=\"Infinity\""
                                     : row[c] == "-∞" ? " data-sort=\"-Infinity\""
                                                      : "";
            const char* const classes = number                    ? " class=\"n\">"
                                        : row[c].size() <= kShort ? " class=\"s\">"
                                                                  : ">";
            html += "<" + kind + (c == 0 ? " scope=\"row\"" : "") + sort + classes + escaped(row[c]) + "</" +
                    kind + ">";
        }
        html += "</tr>\n";
    }
    return html + "</tbody></table></div>\n";
}

std::string pictureHtml(const Picture& picture, const std::string& classes) {
    return "<img" + (classes.empty() ? "" : " class=\"" + classes + "\"") + " width=\"" +
           std::to_string(picture.width) + "\" height=\"" + std::to_string(picture.height) + "\" alt=\"" +
           escaped(picture.alt) + "\" src=\"data:" + picture.type + ";base64," + base64(picture.bytes) +
           "\">";
}

}  // namespace

std::string plainText(std::string_view bytes) {
    std::string text;
    for (std::size_t i = 0; i < bytes.size();) {
        const std::size_t length = characterAt(bytes.substr(i));
        const auto c = static_cast<unsigned char>(bytes[i]);
        const bool control = (c < 0x20 && c != '\n' && c != '\t') || c == 0x7F;
        if (length == 0 || control)
            text += kReplacement, ++i;
        else
            text += bytes.substr(i, length), i += length;
    }
    return text;
}

std::string escaped(std::string_view bytes) {
    std::string html;
    for (const char c : plainText(bytes))
        switch (c) {
            case '&':
                html += "&amp;";
                break;
            case '<':
                html += "&lt;";
                break;
            case '>':
                html += "&gt;";
                break;
            case '"':
                html += "&quot;";
                break;
            case '\'':
                html += "&#39;";
                break;
            default:
                html += c;
        }
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
    std::array<char, 352> text{};
    std::snprintf(text.data(), text.size(), "%.*f", digits, value);
    std::string out = text.data();
    if (out[0] == '-' && out.find_first_of("123456789") == std::string::npos) out.erase(0, 1);
    return out;
}

std::string clockText(double seconds) {
    if (!(seconds >= 0.0) || seconds > 1e9) return "–";
    const auto tenths = std::llround(10.0 * seconds);
    std::array<char, 48> text{};
    std::snprintf(text.data(), text.size(), "%lld:%02lld.%lld", tenths / 600, tenths / 10 % 60, tenths % 10);
    return text.data();
}

Page::Page(const std::string& title, const std::string& lead, const std::string& maker)
    : title_(escaped(title)),
      maker_(escaped(maker)),
      body_("<h1>" + title_ + "</h1>\n<p class=\"lead\">" + escaped(lead) + "</p>\n") {}

void Page::headlines(const std::vector<Headline>& all) {
    body_ += "<ul class=\"figures\">";
    for (const Headline& h : all)
        body_ += "<li><b>" + escaped(h.value) + "</b><span>" + escaped(h.name) + "</span></li>";
    body_ += "</ul>\n";
}

void Page::section(const std::string& title) {
    const std::string id = "section-" + std::to_string(++sections_), text = escaped(title);
    body_ += "<h2 id=\"" + id + "\">" + text + "</h2>\n";
    navigation_ += "<li><a href=\"#" + id + "\">" + text + "</a></li>";
}

void Page::paragraph(const std::string& text) {
    body_ += "<p>" + escaped(text) + "</p>\n";
}

void Page::facts(const std::vector<Fact>& all) {
    body_ += "<dl>";
    for (const Fact& fact : all)
        body_ += "<dt>" + escaped(fact.name) + "</dt><dd>" + escaped(fact.value) + "</dd>\n";
    body_ += "</dl>\n";
}

void Page::table(const Table& table) {
    body_ += tableHtml(table);
}

void Page::foldedTable(const Table& table) {
    body_ +=
        "<details><summary>" + escaped(table.caption) + "</summary>\n" + tableHtml(table) + "</details>\n";
}

void Page::figure(const Figure& figure, const std::string& description, const std::string& caption,
                  const Table& data) {
    const std::string id = "figure-" + std::to_string(++figures_);
    body_ += "<figure>";
    if (!figure.choices.empty()) {
        // Hidden until the script that handles it runs.
        body_ += "<label hidden>Shown: <select id=\"" + id + "-choice\">";
        for (const FigureChoice& choice : figure.choices)
            body_ += "<option>" + escaped(choice.name) + "</option>";
        body_ += "</select></label>\n";
    }
    body_ += std::string("<div class=\"chart") + (figure.low ? " low" : "") + "\"><canvas id=\"" + id +
             "\" role=\"img\" aria-label=\"" + escaped(description) +
             "\"></canvas></div>\n<noscript><p class=\"none\">" +
             "The figure needs JavaScript; its numbers are in the table below.</p></noscript>\n<script "
             "class=\"figure\" "
             "type=\"application/json\" data-for=\"" +
             id + "\">" + figureJson(figure) + "</script>\n<figcaption>" + escaped(caption) +
             "</figcaption>\n<details><summary>Numbers of this figure: " + escaped(data.caption) +
             "</summary>\n" + tableHtml(data) + "</details></figure>\n";
}

void Page::picture(const Picture& picture) {
    body_ += "<figure><div class=\"picture\" role=\"region\" tabindex=\"0\" aria-label=\"" +
             escaped(picture.caption) + "\">" + pictureHtml(picture, "wide") + "</div><figcaption>" +
             escaped(picture.caption) + "</figcaption></figure>\n";
}

void Page::stills(const std::vector<Picture>& all) {
    body_ += "<div class=\"stills\">\n";
    for (const Picture& picture : all)
        body_ += "<figure>" + pictureHtml(picture, "") + "<figcaption>" + escaped(picture.caption) +
                 "</figcaption></figure>\n";
    body_ += "</div>\n";
}

std::string Page::html() const {
    const std::string policy = "default-src 'none'; img-src data:; style-src " + digestOf(pageCss()) +
                               "; script-src " + digestOf(chartJs()) + " " + digestOf(pageJs()) +
                               "; base-uri 'none'; form-action 'none'";
    std::string html = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
    html += "<meta http-equiv=\"Content-Security-Policy\" content=\"" + policy + "\">\n";
    html += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
    html += "<title>" + title_ + "</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>";
    html += pageCss().text;
    html +=
        "</style>\n</head>\n<body>\n<a class=\"skip\" href=\"#main\">Skip to the content</a>\n<main "
        "id=\"main\">\n";
    const std::size_t lead_end = body_.find("</p>\n") + 5;
    html.append(body_, 0, lead_end);
    html += "<nav aria-label=\"Sections\"><ul>" + navigation_ + "</ul></nav>\n";
    html.append(body_, lead_end);
    html += "</main>\n<footer><p>Made by " + maker_ +
            " " STYLET_VERSION
            ". Stylet is a training simulator, not a medical device. This file needs no network: everything "
            "it shows "
            "is inside it.</p></footer>\n";
    if (figures_ > 0 || body_.find("class=\"sortable\"") != std::string::npos) {
        html += "<script>";
        html += chartJs().text;
        html += "</script>\n<script>";
        html += pageJs().text;
        html += "</script>\n";
    }
    return html + "</body>\n</html>\n";
}

void writeText(const std::string& text, const std::filesystem::path& file) {
    writeWholeFile(file, text);
}

void writeCsv(const Table& table, const std::filesystem::path& file) {
    std::string text;
    const auto add = [&](const std::vector<std::string>& row) {
        for (std::size_t c = 0; c < row.size(); ++c) {
            std::string cell = plainText(row[c]);
            if (!numeric(table, c) && !cell.empty() &&
                std::string_view("=+-@\t").find(cell[0]) != std::string::npos)
                cell.insert(0, "'");
            if (cell.find_first_of(",\"\n") != std::string::npos) {
                std::string quoted;
                for (const char q : cell)
                    quoted += q == '"' ? "\"\"" : std::string(1, q);
                cell = "\"" + quoted + "\"";
            }
            text += (c == 0 ? "" : ",") + cell;
        }
        text += '\n';
    };
    add(table.head);
    for (const std::vector<std::string>& row : table.rows)
        add(row);
    writeText(text, file);
}

}  // namespace stylet::report
