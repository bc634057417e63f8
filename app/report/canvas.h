// A drawing canvas: a small wrapper around cairo with the reports' colours and fonts.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace stylet::report {

struct Colour {
    double r = 0.0, g = 0.0, b = 0.0, a = 1.0;
    Colour faded(double alpha) const { return {r, g, b, alpha}; }
};

// The colour at `share` of the way from the first stop to the last, clamped to [0, 1]. The stops are equally
// far apart.
Colour interpolate(std::span<const Colour> stops, double share);

enum class Align { left, centre, right };

struct TextStyle {
    double size = 14.0;
    Colour colour;
    Align align = Align::left;
    bool bold = false;
    Colour halo{0.0, 0.0, 0.0, 0.0};  // around the letters, for text on a picture
};

struct Point {
    double x = 0.0, y = 0.0;
};

// Pixels, origin top left. Text is placed by its baseline.
class Canvas {
  public:
    Canvas(int width, int height, Colour background);
    ~Canvas();
    Canvas(const Canvas&) = delete;
    Canvas& operator=(const Canvas&) = delete;

    void rectangle(double x, double y, double width, double height, Colour);
    void line(Point from, Point to, double width, Colour);
    void dashed(Point from, Point to, double width, Colour);
    void polyline(const std::vector<Point>&, double width, Colour);
    void circle(Point centre, double radius, double width, Colour);
    void disc(Point centre, double radius, Colour);
    void text(Point baseline, const std::string&, const TextStyle&);
    // Like text(), but rotated 90 degrees to the left.
    void textUpward(Point baseline, const std::string&, const TextStyle&);
    double textWidth(const std::string&, const TextStyle&);
    // `rgb` contains width * height packed triples, rows from the top. Drawn enlarged by `scale`.
    void image(double x, double y, int width, int height, const std::vector<std::uint8_t>& rgb,
               double scale = 1.0);
    // Scales everything drawn from now on, including positions and text.
    void scale(double factor);
    // Restricts drawing to this rectangle until unclip().
    void clip(double x, double y, double width, double height);
    void unclip();

    // Copies the canvas as rows from the top of R, G, B and 255. Resizes `rgba`.
    void pixels(std::vector<std::uint8_t>& rgba) const;
    // Throws DataError.
    void savePng(const std::filesystem::path&) const;
    std::vector<std::uint8_t> png() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::report
