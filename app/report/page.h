// One self-contained HTML page: it opens without a network, its numbers stand in tables, its figures need a
// browser that runs scripts. All text is taken as text, whatever stands in it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/report/figure.h"

namespace stylet::report {

struct Table {
    std::string caption;
    std::vector<std::string> head;
    std::vector<std::vector<std::string>> rows;  // the first of each names its row
    std::vector<bool> number{};                  // per column: right-aligned, sorted as numbers
    bool sortable = false;
};

struct Fact {
    std::string name, value;
};

// A number that a reader should see first.
struct Headline {
    std::string value, name;
};

struct Picture {
    std::vector<std::uint8_t> bytes;
    std::string type;  // image/png, image/jpeg
    int width = 0, height = 0;
    std::string alt, caption;
};

class Page {
  public:
    // `maker` is the program whose page it is.
    Page(const std::string& title, const std::string& lead, const std::string& maker = "stylet-report");

    void headlines(const std::vector<Headline>&);
    // Named in the page's navigation.
    void section(const std::string& title);
    void paragraph(const std::string& text);
    void facts(const std::vector<Fact>&);
    void table(const Table&);
    // Out of the way until it is asked for.
    void foldedTable(const Table&);
    // `description` is what the figure shows, for who does not see it; `caption` stands beneath it; `data`
    // has its numbers.
    void figure(const Figure&, const std::string& description, const std::string& caption, const Table& data);
    void picture(const Picture&);
    void stills(const std::vector<Picture>&);

    std::string html() const;

  private:
    std::string title_, maker_, body_, navigation_;
    int sections_ = 0, figures_ = 0;
};

// Of any bytes: text in UTF-8 without control characters; what is neither becomes the replacement character.
std::string plainText(std::string_view bytes);
// plainText for an HTML element or a quoted attribute.
std::string escaped(std::string_view bytes);
std::string base64(std::span<const std::uint8_t>);

// %.*f without "-0"; "–" for what is not a number, "∞".
std::string fixed(double value, int digits);
// minutes:seconds
std::string clockText(double seconds);

// Comma-separated, quoted where needed, and no cell is a formula to a spreadsheet. Throws patient::DataError.
void writeCsv(const Table&, const std::filesystem::path&);
// Throws patient::DataError.
void writeText(const std::string&, const std::filesystem::path&);

}  // namespace stylet::report
