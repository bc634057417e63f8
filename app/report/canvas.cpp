#include "app/report/canvas.h"

#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/whole_file.h"
#include "patient/patient.h"

#ifdef STYLET_SANITIZED
// fontconfig keeps its font patterns until the process ends. The leak checker cannot see that they are in
// use.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
    return "leak:libfontconfig\n";
}
extern "C" const char* __lsan_default_options();
extern "C" const char* __lsan_default_options() {
    return "print_suppressions=0";
}
#endif

namespace stylet::report {

namespace {

constexpr double kPi = 3.14159265358979323846;

struct Destroy {
    void operator()(cairo_surface_t* s) const { cairo_surface_destroy(s); }
    void operator()(cairo_t* c) const { cairo_destroy(c); }
};
using Surface = std::unique_ptr<cairo_surface_t, Destroy>;

void use(cairo_t* c, const Colour& colour) {
    cairo_set_source_rgba(c, colour.r, colour.g, colour.b, colour.a);
}

void use(cairo_t* c, const TextStyle& style) {
    cairo_select_font_face(c, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                           style.bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(c, style.size);
    use(c, style.colour);
}

double advance(cairo_t* c, const std::string& text) {
    cairo_text_extents_t extents;
    cairo_text_extents(c, text.c_str(), &extents);
    return extents.x_advance;
}

double shift(cairo_t* c, const std::string& text, Align align) {
    if (align == Align::left) return 0.0;
    return -advance(c, text) * (align == Align::centre ? 0.5 : 1.0);
}

}  // namespace

Colour interpolate(std::span<const Colour> stops, double share) {
    const double at = std::clamp(share, 0.0, 1.0) * double(stops.size() - 1);
    const auto low = std::min(std::size_t(at), stops.size() - 2);
    const double t = at - double(low);
    const Colour &a = stops[low], &b = stops[low + 1];
    return {a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b)};
}

struct Canvas::Impl {
    Surface surface;
    std::unique_ptr<cairo_t, Destroy> context;
};

Canvas::Canvas(int width, int height, Colour background) : impl_(new Impl) {
    impl_->surface.reset(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height));
    impl_->context.reset(cairo_create(impl_->surface.get()));
    cairo_set_line_join(impl_->context.get(), CAIRO_LINE_JOIN_ROUND);
    rectangle(0, 0, width, height, background);
}

Canvas::~Canvas() = default;

void Canvas::rectangle(double x, double y, double width, double height, Colour colour) {
    cairo_t* c = impl_->context.get();
    use(c, colour);
    cairo_rectangle(c, x, y, width, height);
    cairo_fill(c);
}

void Canvas::line(Point from, Point to, double width, Colour colour) {
    polyline({from, to}, width, colour);
}

void Canvas::dashed(Point from, Point to, double width, Colour colour) {
    const double dash = 5.0;
    cairo_set_dash(impl_->context.get(), &dash, 1, 0.0);
    line(from, to, width, colour);
    cairo_set_dash(impl_->context.get(), nullptr, 0, 0.0);
}

void Canvas::polyline(const std::vector<Point>& points, double width, Colour colour) {
    cairo_t* c = impl_->context.get();
    use(c, colour);
    cairo_set_line_width(c, width);
    for (const Point& p : points)
        cairo_line_to(c, p.x, p.y);
    cairo_stroke(c);
}

void Canvas::circle(Point centre, double radius, double width, Colour colour) {
    cairo_t* c = impl_->context.get();
    use(c, colour);
    cairo_set_line_width(c, width);
    cairo_arc(c, centre.x, centre.y, radius, 0.0, 2.0 * kPi);
    cairo_stroke(c);
}

void Canvas::disc(Point centre, double radius, Colour colour) {
    cairo_t* c = impl_->context.get();
    use(c, colour);
    cairo_arc(c, centre.x, centre.y, radius, 0.0, 2.0 * kPi);
    cairo_fill(c);
}

void Canvas::text(Point baseline, const std::string& text, const TextStyle& style) {
    cairo_t* c = impl_->context.get();
    use(c, style);
    const double x = baseline.x + shift(c, text, style.align);
    if (style.halo.a > 0.0) {
        cairo_move_to(c, x, baseline.y);
        cairo_text_path(c, text.c_str());
        cairo_set_line_width(c, 4.0);
        use(c, style.halo);
        cairo_stroke(c);
        use(c, style.colour);
    }
    cairo_move_to(c, x, baseline.y);
    cairo_show_text(c, text.c_str());
    cairo_new_path(c);
}

void Canvas::textUpward(Point baseline, const std::string& text, const TextStyle& style) {
    cairo_t* c = impl_->context.get();
    use(c, style);
    cairo_save(c);
    cairo_translate(c, baseline.x, baseline.y);
    cairo_rotate(c, -kPi / 2.0);
    cairo_move_to(c, shift(c, text, style.align), 0.0);
    cairo_show_text(c, text.c_str());
    cairo_new_path(c);
    cairo_restore(c);
}

double Canvas::textWidth(const std::string& text, const TextStyle& style) {
    use(impl_->context.get(), style);
    return advance(impl_->context.get(), text);
}

void Canvas::image(double x, double y, int width, int height, const std::vector<std::uint8_t>& rgb,
                   double scale) {
    const Surface picture(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height));
    unsigned char* rows = cairo_image_surface_get_data(picture.get());
    const int stride = cairo_image_surface_get_stride(picture.get());
    for (int j = 0; j < height; ++j)
        for (int i = 0; i < width; ++i) {
            const std::uint8_t* from = &rgb[3 * (std::size_t(j) * std::size_t(width) + std::size_t(i))];
            // RGB24 is a native 32-bit word 0x00rrggbb.
            auto* to = reinterpret_cast<std::uint32_t*>(rows + std::ptrdiff_t(j) * stride) + i;
            *to = std::uint32_t(from[0]) << 16 | std::uint32_t(from[1]) << 8 | from[2];
        }
    cairo_surface_mark_dirty(picture.get());
    cairo_save(impl_->context.get());
    cairo_translate(impl_->context.get(), x, y);
    cairo_scale(impl_->context.get(), scale, scale);
    cairo_set_source_surface(impl_->context.get(), picture.get(), 0.0, 0.0);
    cairo_paint(impl_->context.get());
    cairo_restore(impl_->context.get());
}

void Canvas::scale(double factor) {
    cairo_scale(impl_->context.get(), factor, factor);
}

void Canvas::clip(double x, double y, double width, double height) {
    cairo_save(impl_->context.get());
    cairo_rectangle(impl_->context.get(), x, y, width, height);
    cairo_clip(impl_->context.get());
}

void Canvas::unclip() {
    cairo_restore(impl_->context.get());
}

void Canvas::pixels(std::vector<std::uint8_t>& rgba) const {
    cairo_surface_t* surface = impl_->surface.get();
    cairo_surface_flush(surface);
    const unsigned char* rows = cairo_image_surface_get_data(surface);
    const int width = cairo_image_surface_get_width(surface),
              height = cairo_image_surface_get_height(surface);
    const int stride = cairo_image_surface_get_stride(surface);
    rgba.resize(std::size_t(width) * std::size_t(height) * 4);
    std::size_t at = 0;
    for (int j = 0; j < height; ++j)
        for (int i = 0; i < width; ++i) {
            std::uint32_t word = 0;
            std::memcpy(&word, rows + std::ptrdiff_t(j) * stride + std::ptrdiff_t(i) * 4, sizeof word);
            rgba[at++] = std::uint8_t(word >> 16);
            rgba[at++] = std::uint8_t(word >> 8);
            rgba[at++] = std::uint8_t(word);
            rgba[at++] = 255;
        }
}

void Canvas::savePng(const std::filesystem::path& file) const {
    const std::vector<std::uint8_t> bytes = png();
    writeWholeFile(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

std::vector<std::uint8_t> Canvas::png() const {
    std::vector<std::uint8_t> bytes;
    const auto keep = [](void* to, const unsigned char* data, unsigned int length) {
        auto& all = *static_cast<std::vector<std::uint8_t>*>(to);
        all.insert(all.end(), data, data + length);
        return CAIRO_STATUS_SUCCESS;
    };
    const cairo_status_t status = cairo_surface_write_to_png_stream(impl_->surface.get(), keep, &bytes);
    if (status != CAIRO_STATUS_SUCCESS) throw DataError("picture", "png", cairo_status_to_string(status));
    return bytes;
}

}  // namespace stylet::report
