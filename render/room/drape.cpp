#include "render/room/drape.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "base/smoothstep.h"

namespace stylet::render {
namespace {

constexpr int kArc = 65, kFall = 5, kFlat = 3, kHang = 7;  // columns: on the body; on either side
constexpr int kColumns = kArc + 2 * (kFall + kFlat + kHang);
constexpr double kRow_m = 0.009, kLegRow_m = 0.035;
constexpr double kGap_m = 0.005, kOnTable_m = 0.006;
constexpr double kReach_m = 0.34;    // radius at which the search for the skin begins
constexpr double kRound_rad = 1.75;  // angle from the top at which the cloth leaves the body
constexpr double kTableEdge_m = 0.302, kHangs_m = 0.33;
constexpr double kLegs_m = 1.05;  // from the trunk's end to the end of the cloth
constexpr double kBarHeight_m = 0.46, kBarHalf_m = 0.37, kBarBehind_m = 0.075;
constexpr int kLegRows = int(kLegs_m / kLegRow_m), kHeadRows = 18;
constexpr int kRimPoints = 80, kRimSides = 8;
constexpr double kRimRadius_m = 0.0042;
constexpr int kMinBody = 2;  // consecutive samples of body; fewer are noise

// The trunk in cylinder coordinates about an axis along z: radius as a function of z and of the angle from
// the top (> 0: to the right).
struct Trunk {
    double x_m = 0.0, y_m = 0.0;  // position of the axis
    double z0_m = 0.0, z1_m = 0.0;
    double angle0 = -kRound_rad, angle1 = kRound_rad;
    int rows = 2;
    std::vector<double> radius_m;  // kArc per row

    double angleAround(double column) const { return angle0 + (angle1 - angle0) * column / (kArc - 1); }
    double radiusAt(double angle, double z_m) const {
        const double c = std::clamp((angle - angle0) / (angle1 - angle0) * (kArc - 1), 0.0, kArc - 1.001);
        const double r = std::clamp((z_m - z0_m) / (z1_m - z0_m) * (rows - 1), 0.0, rows - 1.001);
        const auto c0 = std::size_t(c), r0 = std::size_t(r);
        const auto at = [&](std::size_t row, std::size_t column) { return radius_m[row * kArc + column]; };
        const double u = c - double(c0), v = r - double(r0);
        return (1.0 - v) * ((1.0 - u) * at(r0, c0) + u * at(r0, c0 + 1)) +
               v * ((1.0 - u) * at(r0 + 1, c0) + u * at(r0 + 1, c0 + 1));
    }
    Vec3 pointAt(double angle, double z_m, double out_m) const {
        const double r = radiusAt(angle, z_m) + out_m;
        return {x_m + r * std::sin(angle), y_m + r * std::cos(angle), z_m};
    }
};

bool inBody(const patient::Package& package, const Vec3& p) {
    const Index3 i = package.ct.grid.nearest(p);
    return package.ct.grid.contains(i) && double(package.ct[i]) >= package.thresholds.t0_hu;
}

double skinRadius(const patient::Package& body, const Trunk& trunk, double angle, double z_m, double step_m,
                  double back_m) {
    int met = 0;
    for (double r = kReach_m; r > 0.05; r -= step_m) {
        const Vec3 p(trunk.x_m + r * std::sin(angle), trunk.y_m + r * std::cos(angle), z_m);
        met = p.y > back_m && inBody(body, p) ? met + 1 : 0;
        if (met == kMinBody) return r + kMinBody * step_m;
    }
    return 0.05;
}

// Smooths the trunk as cloth does: it bridges gaps and rounds sharp edges.
void stretch(Trunk& trunk) {
    std::vector<double> next(trunk.radius_m.size());
    for (int pass = 0; pass < 4; ++pass) {
        for (int row = 0; row < trunk.rows; ++row)
            for (int c = 0; c < kArc; ++c) {
                double sum = 0.0, most = 0.0;
                for (int dr = -1; dr <= 1; ++dr)
                    for (int dc = -1; dc <= 1; ++dc) {
                        const int r = std::clamp(row + dr, 0, trunk.rows - 1);
                        const double v =
                            trunk.radius_m[std::size_t(r * kArc + std::clamp(c + dc, 0, kArc - 1))];
                        sum += v, most = std::max(most, v);
                    }
                next[std::size_t(row * kArc + c)] = pass == 0 ? most : sum / 9.0;
            }
        std::swap(next, trunk.radius_m);
    }
}

Trunk findTrunk(const patient::Patient& patient, double back_m, const Vec3& field_m) {
    const Grid& grid = patient.grid();
    const Vec3 far = grid.centre(grid.dims - 1);
    const patient::Package& body = patient.package();
    Trunk trunk;
    trunk.x_m = 0.5 * (grid.origin_m.x + far.x);
    trunk.z0_m = grid.origin_m.z, trunk.z1_m = far.z;
    double top = back_m + 0.05;
    for (double y = far.y; y > top; y -= grid.spacing_m.y)
        if (inBody(body, {trunk.x_m, y, 0.5 * (trunk.z0_m + trunk.z1_m)})) top = y;
    trunk.y_m = 0.5 * (back_m + top);
    // The opening must lie on the body, so extend the arc far enough down on its side.
    const double angle = std::atan2(field_m.x - trunk.x_m, field_m.y - trunk.y_m);
    trunk.angle1 = std::clamp(angle + 0.75, kRound_rad, 2.3);
    trunk.angle0 = -std::clamp(0.75 - angle, kRound_rad, 2.3);
    trunk.rows = std::max(2, int((trunk.z1_m - trunk.z0_m) / kRow_m) + 1);
    const double step = 0.8 * std::min(grid.spacing_m.x, grid.spacing_m.y);
    for (int row = 0; row < trunk.rows; ++row)
        for (int c = 0; c < kArc; ++c)
            trunk.radius_m.push_back(
                skinRadius(body, trunk, trunk.angleAround(c),
                           trunk.z0_m + (trunk.z1_m - trunk.z0_m) * row / (trunk.rows - 1), step, back_m));
    stretch(trunk);
    return trunk;
}

struct Node {
    Vec3 p{0.0}, anchor{0.0};
    double follows = 0.0, fold_m = 0.0, open = 1.0;
    double from_opening = 9.0;  // relative distance from the opening's middle: 1 on its edge
};

// Builds the rows of the cloth from the feet to the head.
class DrapeBuilder {
  public:
    DrapeBuilder(const patient::Patient& patient, double back_m, const Vec3& field_m)
        : trunk_(findTrunk(patient, back_m, field_m)), floor_m_(back_m + kOnTable_m) {
        field_z_m_ = field_m.z;
        field_angle_ = std::atan2(field_m.x - trunk_.x_m, field_m.y - trunk_.y_m);
        field_radius_m_ = trunk_.radiusAt(field_angle_, field_z_m_) + kGap_m;
        for (int i = kLegRows; i > 0; --i)
            row(trunk_.z0_m - kLegRow_m * i);
        for (int i = 0; i < trunk_.rows; ++i)
            row(trunk_.z0_m + (trunk_.z1_m - trunk_.z0_m) * i / (trunk_.rows - 1));
        for (int i = 1; i <= kHeadRows; ++i)
            headRow(i);
    }

    DrapeShape shape() {
        fold();
        DrapeShape made;
        for (std::size_t i = 0; i < nodes_.size(); ++i)
            put(made, nodes_[i].p, normalAt(i), nodes_[i]);
        const int rows = int(nodes_.size()) / kColumns;
        for (int r = 0; r + 1 < rows; ++r)
            for (int c = 0; c + 1 < kColumns; ++c) {
                const auto a = std::uint32_t(r * kColumns + c), b = a + 1, d = a + kColumns, e = d + 1;
                triangle(made, a, d, e);
                triangle(made, a, e, b);
            }
        addRim(made);
        return made;
    }

  private:
    double edge(double angle, double z_m) const {
        const double u = std::fabs(angle - field_angle_) * field_radius_m_ / kOpeningAround_m;
        const double v = std::fabs(z_m - field_z_m_) / kOpeningAlong_m;
        return std::sqrt(std::sqrt(u * u * u * u + v * v * v * v));
    }

    // Node over the trunk, or over the legs, which the CT does not show.
    Node overBody(int column, double z_m) const {
        Node node;
        double angle = trunk_.angleAround(column);
        const double beyond = std::max({trunk_.z0_m - z_m, z_m - trunk_.z1_m, 0.0});
        node.from_opening = beyond > 0.0 ? 9.0 : edge(angle, z_m);
        if (std::fabs(node.from_opening - 1.0) < 0.075) {  // move it onto the opening's edge
            angle = field_angle_ + (angle - field_angle_) / node.from_opening;
            z_m = field_z_m_ + (z_m - field_z_m_) / node.from_opening;
            node.from_opening = 1.0;
        }
        const double z = std::clamp(z_m, trunk_.z0_m, trunk_.z1_m);
        if (z == trunk_.z0_m || z == trunk_.z1_m)  // the opening ends with the trunk
            node.from_opening = std::max(node.from_opening, 1.0);
        node.anchor = trunk_.pointAt(angle, z, 0.0);
        node.p = trunk_.pointAt(angle, z, kGap_m);
        node.p.z = z_m;
        node.follows = smoothStep(0.0, 0.03, z_m - trunk_.z0_m) * smoothStep(0.0, 0.03, trunk_.z1_m - z_m);
        if (z_m < trunk_.z0_m) {
            const double t = smoothStep(0.0, 0.30, beyond), along = beyond / kLegs_m;
            const double turn = angle / kRound_rad * 0.5 * std::numbers::pi;
            const double x = (0.19 - 0.06 * along) * std::sin(turn);
            const double knees = 0.02 * std::exp(-std::pow((along - 0.42) / 0.12, 2.0));
            const double feet = 0.10 * std::exp(-std::pow((along - 0.90) / 0.05, 2.0));
            const double between = 0.045 * t * std::exp(-x * x / 0.0012);
            const double y = (0.145 - 0.07 * along + knees + feet - between) * std::max(0.0, std::cos(turn));
            node.p = glm::mix(node.p, Vec3(trunk_.x_m + x, floor_m_ + y, z_m), t);
        }
        node.p.y = std::max(node.p.y, floor_m_);
        node.fold_m = node.from_opening > 8.0 ? 0.006 : 0.0025 * smoothStep(1.2, 2.4, node.from_opening);
        return node;
    }

    // Adds nodes from the body down to the table, over its edge and on toward the floor.
    void side(const Node& last, double sign, std::vector<Node>& out) const {
        const double height = last.p.y - floor_m_;
        const double land = last.p.x + sign * (0.02 + 0.30 * height);
        const double brink = trunk_.x_m + sign * std::max(kTableEdge_m, sign * (land - trunk_.x_m) + 0.02);
        const Vec3 below(last.p.x + sign * 0.008, floor_m_ + 0.12 * height, last.p.z),
            landed(land, floor_m_, last.p.z);
        for (int i = 1; i <= kFall; ++i) {
            const double t = double(i) / kFall;
            Node node = last;
            node.p = (1.0 - t) * (1.0 - t) * last.p + 2.0 * t * (1.0 - t) * below + t * t * landed;
            node.p.y = std::max(node.p.y, floor_m_);
            node.follows = last.follows * (1.0 - t);
            node.open = 1.0 - 0.3 * t, node.fold_m = 0.004;
            out.push_back(node);
        }
        for (int i = 1; i <= kFlat; ++i) {
            Node node = last;
            node.p = {glm::mix(land, brink, double(i) / kFlat), floor_m_, last.p.z};
            node.follows = 0.0, node.fold_m = 0.002, node.open = i == kFlat ? 1.0 : 0.85;
            out.push_back(node);
        }
        for (int i = 1; i <= kHang; ++i) {
            const double t = double(i) / kHang;
            Node node = last;
            node.p = {brink + sign * 0.012 * (1.0 - (1.0 - t) * (1.0 - t)),
                      floor_m_ - kHangs_m * t * (0.4 + 0.6 * t), last.p.z};
            node.follows = 0.0, node.fold_m = 0.004 + 0.018 * t, node.open = 0.95 - 0.25 * t;
            out.push_back(node);
        }
    }

    std::vector<Node> rowAt(double z_m) const {
        std::vector<Node> arc, left, right, all;
        for (int c = 0; c < kArc; ++c)
            arc.push_back(overBody(c, z_m));
        side(arc.front(), -1.0, left);
        side(arc.back(), 1.0, right);
        all.assign(left.rbegin(), left.rend());
        all.insert(all.end(), arc.begin(), arc.end());
        all.insert(all.end(), right.begin(), right.end());
        return all;
    }

    void row(double z_m) {
        const std::vector<Node> made = rowAt(z_m);
        nodes_.insert(nodes_.end(), made.begin(), made.end());
    }

    // Adds row `i` at the head: a few rows over the chest, then up to the bar, over it and down behind it.
    void headRow(int i) {
        constexpr int kChest = 4, kRise = 9;
        const double z = trunk_.z1_m + 0.02 * std::min(i, kChest);
        const double rise = smoothStep(0.0, 1.0, double(i - kChest) / kRise);
        const int behind = std::max(0, i - kChest - kRise);
        for (std::size_t c = 0; const Node& flat : rowAt(z)) {
            const double s = 2.0 * double(c++) / (kColumns - 1) - 1.0;
            // Along the bar, then down at its ends.
            const double along = std::clamp(s * 1.55, -1.0, 1.0),
                         down = std::max(0.0, std::fabs(s) - 1.0 / 1.55);
            Node node = flat;
            const Vec3 hung(trunk_.x_m + along * kBarHalf_m + std::copysign(0.03 * down, s),
                            floor_m_ + kBarHeight_m - 2.1 * down - 0.012 * (1.0 - along * along),
                            z + kBarBehind_m * rise);
            node.p = glm::mix(flat.p, hung, rise);
            node.p.z = z + kBarBehind_m * rise + 0.012 * behind;
            node.p.y -= 0.010 * behind * behind;
            node.follows = 0.0, node.fold_m = 0.004 + 0.010 * rise * (1.0 - 0.3 * behind), node.open = 0.95;
            nodes_.push_back(node);
        }
    }

    Vec3 normalAt(std::size_t i) const {
        const std::size_t rows = nodes_.size() / kColumns, r = i / kColumns, c = i % kColumns;
        const auto at = [&](std::size_t row, std::size_t column) {
            return nodes_[row * kColumns + column].p;
        };
        const Vec3 across = at(r, std::min(c + 1, std::size_t(kColumns - 1))) - at(r, c == 0 ? 0 : c - 1);
        const Vec3 along = at(std::min(r + 1, rows - 1), c) - at(r == 0 ? 0 : r - 1, c);
        const Vec3 n = glm::cross(along, across);
        const double length = glm::length(n);
        return length > 1e-12 ? n / length : Vec3(0.0, 1.0, 0.0);
    }

    // Adds soft folds, deeper where the cloth hangs free.
    void fold() {
        std::vector<Vec3> normals(nodes_.size());
        for (std::size_t i = 0; i < nodes_.size(); ++i)
            normals[i] = normalAt(i);
        for (std::size_t i = 0; i < nodes_.size(); ++i) {
            Node& node = nodes_[i];
            const double x = node.p.x + 0.6 * node.p.y, z = node.p.z;
            const double hanging = smoothStep(0.006, 0.016, node.fold_m);
            const double lying =
                std::sin(37.0 * x + 2.2 * std::sin(9.0 * z)) * std::sin(14.0 * z + 1.9 * std::sin(13.0 * x));
            const double hung = 0.7 * std::sin(29.0 * z + 2.1 * std::sin(6.1 * z)) +
                                0.3 * std::sin(57.0 * z + 23.0 * node.p.x);
            node.p += node.fold_m * glm::mix(0.5 + 0.5 * lying, 0.5 + 0.5 * hung, hanging) * normals[i];
        }
    }

    void put(DrapeShape& made, const Vec3& p, const Vec3& normal, const Node& node) const {
        made.vertices.push_back({glm::vec3(p), glm::vec3(normal), glm::vec2(0.0f), float(node.open)});
        made.anchors_m.push_back(node.anchor);
        made.follows.push_back(float(node.follows));
    }

    void triangle(DrapeShape& made, std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
        for (const std::uint32_t i : {a, b, c})
            if (nodes_[i].from_opening < 0.999) return;
        made.indices.insert(made.indices.end(), {a, b, c});
    }

    // Adds the rim of cloth that is folded over around the opening.
    void addRim(DrapeShape& made) const {
        const auto first = std::uint32_t(made.vertices.size());
        const auto onEdge = [&](double turn) {
            const double c = std::cos(turn), s = std::sin(turn);
            const double k = 1.0 / std::sqrt(std::sqrt(c * c * c * c + s * s * s * s));
            const double angle = field_angle_ + k * c * kOpeningAround_m / field_radius_m_;
            const double z = std::clamp(field_z_m_ + k * s * kOpeningAlong_m, trunk_.z0_m, trunk_.z1_m);
            Node node;
            node.anchor = trunk_.pointAt(angle, z, 0.0);
            node.p = trunk_.pointAt(angle, z, kGap_m);
            node.follows = smoothStep(0.0, 0.03, z - trunk_.z0_m) * smoothStep(0.0, 0.03, trunk_.z1_m - z);
            return node;
        };
        for (int i = 0; i < kRimPoints; ++i) {
            const double turn = 2.0 * std::numbers::pi * i / kRimPoints;
            const Node node = onEdge(turn);
            const Vec3 chord = onEdge(turn + 0.02).p - onEdge(turn - 0.02).p;
            const Vec3 along = glm::length(chord) > 1e-9 ? glm::normalize(chord) : Vec3(0.0, 0.0, 1.0);
            const Vec3 up = glm::normalize(Vec3(node.p.x - trunk_.x_m, node.p.y - trunk_.y_m, 0.0));
            const Vec3 aside = glm::normalize(glm::cross(along, up));
            const Vec3 out = glm::cross(aside, along);
            for (int k = 0; k < kRimSides; ++k) {
                const double a = 2.0 * std::numbers::pi * k / kRimSides;
                const Vec3 n = std::cos(a) * aside + std::sin(a) * out;
                put(made, node.p + kRimRadius_m * (std::cos(a) * 1.3 * aside + std::sin(a) * 0.8 * out), n,
                    node);
            }
        }
        for (std::uint32_t i = 0; i < kRimPoints; ++i)
            for (std::uint32_t k = 0; k < kRimSides; ++k) {
                const std::uint32_t j = (i + 1) % kRimPoints, l = (k + 1) % kRimSides;
                const auto at = [&](std::uint32_t point, std::uint32_t side_) {
                    return first + point * kRimSides + side_;
                };
                made.indices.insert(made.indices.end(),
                                    {at(i, k), at(j, k), at(j, l), at(i, k), at(j, l), at(i, l)});
            }
    }

    Trunk trunk_;
    double floor_m_ = 0.0, field_z_m_ = 0.0, field_angle_ = 0.0, field_radius_m_ = 0.15;
    std::vector<Node> nodes_;
};

const MeshPart kCloth{.name = "drape",
                      .node = "drape",
                      .colour_linear = {0.030f, 0.155f, 0.185f},
                      .metallic = 0.0f,
                      .roughness = 0.85f};

}  // namespace

DrapeShape makeDrape(const patient::Patient& patient, double back_m, const Vec3& field_m) {
    return DrapeBuilder(patient, back_m, field_m).shape();
}

void moveDrape(const DrapeShape& shape, const patient::MotionModel& motion, const patient::Surrogate& breath,
               std::span<glm::vec3> moved_m) {
    for (std::size_t i = 0; i < shape.vertices.size(); ++i) {
        moved_m[i] = shape.vertices[i].position_m;
        if (shape.follows[i] == 0.0f) continue;
        const Vec3 way =
            patient::deformedFromReference(motion, breath, shape.anchors_m[i]) - shape.anchors_m[i];
        moved_m[i] += shape.follows[i] * glm::vec3(way);
    }
}

Drape::Drape(const Gpu& gpu, const patient::Patient& patient, double back_m, const Vec3& field_m)
    : patient_(&patient),
      field_m_(field_m),
      shape_(makeDrape(patient, back_m, field_m)),
      moved_m_(shape_.vertices.size()),
      breath_(patient.package().motion.reference) {
    std::vector<RoomVertex> vertices;
    glm::vec3 low(1e9f), high(-1e9f);
    for (const Vertex& v : shape_.vertices) {
        vertices.push_back(roomVertex(v, kCloth));
        low = glm::min(low, v.position_m), high = glm::max(high, v.position_m);
    }
    model_ = {0, std::uint32_t(shape_.indices.size()), 0.5f * (low + high), 0.5f * glm::length(high - low)};
    vertex_buffer_ = makeFilledBuffer(gpu, vertices, vk::BufferUsageFlagBits::eVertexBuffer);
    index_buffer_ = makeFilledBuffer(gpu, shape_.indices, vk::BufferUsageFlagBits::eIndexBuffer);
}

void Drape::breathe(const patient::Surrogate& breath) {
    if (breath == breath_) return;
    breath_ = breath;
    moveDrape(shape_, patient_->package().motion, breath, moved_m_);
    auto* vertices = static_cast<RoomVertex*>(vertex_buffer_.mapped);
    for (std::size_t i = 0; i < moved_m_.size(); ++i)
        vertices[i].position_m = moved_m_[i];
}

}  // namespace stylet::render
