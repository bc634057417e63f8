// One self-contained HTML page that opens without a network. Its numbers are in tables; its figures need
// JavaScript. All text is escaped.
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
    std::vector<std::vector<std::string>> rows;  // the first cell of a row is its heading
    std::vector<bool> number{};                  // per column: right-aligned, sorted as numbers
    bool sortable = false;
    std::vector<std::string> row_ids{};  // per row: what a link names; empty: none
};

struct Fact {
    std::string name, value;
};

// A key number shown first on the page.
struct Headline {
    std::string value, name;
};

struct Picture {
    std::vector<std::uint8_t> bytes;
    std::string type;  // image/png, image/jpeg
    int width = 0, height = 0;
    std::string alt, caption;
};

struct DescribedFigure {
    Figure figure;
    std::string description;  // what the figure shows, for screen readers
    std::string caption;      // shown below it
    Table data;               // its numbers
};

class Page {
  public:
    // `maker` is the name of the program that makes the page.
    Page(const std::string& title, const std::string& lead, const std::string& maker = "stylet-report");

    // Call first. The page's navigation follows them.
    void headlines(const std::vector<Headline>&);
    // Adds the section to the page's navigation.
    void section(const std::string& title);
    void paragraph(const std::string& text);
    // A numbered advice, with a link to the id of a row of a table.
    void advice(std::size_t number, const std::string& text, const std::string& link,
                const std::string& row_id);
    void facts(const std::vector<Fact>&);
    void table(const Table&);
    // A table that is collapsed until the reader opens it.
    void collapsibleTable(const Table&);
    void figure(const DescribedFigure&);
    void picture(const Picture&);
    void stills(const std::vector<Picture>&);

    // True if the term occurs in the page so far, in capitals or not.
    bool mentions(std::string_view term) const;

    std::string html() const;

  private:
    std::string title_, maker_, body_, navigation_;
    std::size_t navigation_at_ = 0;  // in the body
    int sections_ = 0, figures_ = 0;
};

// Converts any bytes to UTF-8 text. Invalid bytes, control characters except newline and tab, and characters
// that reverse the direction of the text after them become the replacement character.
std::string plainText(std::string_view bytes);
// plainText for an HTML element or a quoted attribute.
std::string escaped(std::string_view bytes);
std::string base64(std::span<const std::uint8_t>);

// Formats with %.*f, without "-0"; "–" for NaN, "∞" for infinity.
std::string fixed(double value, int digits);
// minutes:seconds
std::string clockText(double seconds);

// The table as CSV. No cell can be a formula in a spreadsheet (csvRow() in base/csv.h). Throws DataError.
void writeCsv(const Table&, const std::filesystem::path&);

}  // namespace stylet::report
