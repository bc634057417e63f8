#include <array>
#include <bit>
#include <glm/geometric.hpp>
#include <limits>
#include <stdexcept>

#include "base/geodesic.h"
#include "base/statistics.h"
#include "base/traversal.h"
#include "patient/package/origin.h"
#include "patient/synth/check_tools.h"
#include "patient/synth/duct_branches.h"
#include "patient/synth/labels.h"
#include "patient/synth/synth.h"

namespace stylet::patient::synth {

namespace {

constexpr double kAny = std::numeric_limits<double>::infinity();
constexpr IdSet kTrees = anyOf({Id::portal, Id::hepaticVeins, Id::ducts});

class Checker {
  public:
    explicit Checker(const Package& package)
        : package_(package),
          labels_(package.labels),
          grid_(package.labels.grid),
          mm_(grid_.spacing_m.x * 1000.0) {}

    std::vector<CheckLine> run() {
        collect();
        volumes();
        ribGaps();
        ductTree();
        pieces();
        surfaces();
        meanHu();
        flankAccess();
        return std::move(lines_);
    }

  private:
    const std::vector<std::size_t>& of(Id id) const { return voxels_[std::size_t(id)]; }
    void line(std::string name, std::string unit, double value, double low, double high) {
        lines_.push_back({std::move(name), std::move(unit), value, low, high});
    }
    double millilitres(std::size_t voxels) const { return double(voxels) * mm_ * mm_ * mm_ / 1000.0; }

    void collect() {
        for (std::size_t n = 0; n < labels_.voxels.size(); ++n)
            if (labels_.voxels[n] != 0 && labels_.voxels[n] < kIdCount)
                voxels_[labels_.voxels[n]].push_back(n);
    }

    // Voxels of a tree inside the liver: those surrounded mostly by liver.
    std::vector<std::size_t> insideLiver(Id id) const {
        const int reach = std::max(1, int(7.0 / mm_));
        std::vector<std::size_t> inside;
        for (const std::size_t n : of(id)) {
            const Index3 at = grid_.voxelAt(n);
            int around = 0;
            for (const Index3& step : kFaceSteps) {
                const Index3 j = at + step * reach;
                around += grid_.contains(j) && contains(kTrees | only(Id::liver), labels_[j]);
            }
            if (around >= 5) inside.push_back(n);
        }
        return inside;
    }

    void volumes() {
        ducts_ = insideLiver(Id::ducts);
        const double liver =
            millilitres(of(Id::liver).size() + ducts_.size() + insideLiver(Id::portal).size() +
                        insideLiver(Id::hepaticVeins).size());
        line("liver volume", "l", liver / 1000.0, 1.1, 1.9);
        line("spleen volume", "ml", millilitres(of(Id::spleen).size()), 100, 320);
        line("right kidney volume", "ml", millilitres(of(Id::kidneyRight).size()), 90, 220);
        line("left kidney volume", "ml", millilitres(of(Id::kidneyLeft).size()), 90, 220);
        line("gallbladder volume", "ml", millilitres(of(Id::gallbladder).size()), 10, 70);
        line("pancreas volume", "ml", millilitres(of(Id::pancreas).size()), 25, 120);
    }

    // Measures the gaps between neighbouring right ribs, from surface to surface, within 40 mm of the
    // mid-axillary line.
    void ribGaps() {
        const double half_band_mm = 40.0;
        const double middle_mm = 4.0;  // y of the mid-axillary line
        struct FlankRib {
            std::vector<Vec3> points_mm;
            double z_mm = 0.0;
        };
        std::vector<FlankRib> ribs;
        for (const auto& component : connectedComponents(labels_, labelSet(only(Id::ribsRight)))) {
            FlankRib rib;
            for (const std::size_t n : component) {
                const Vec3 p = grid_.centre(grid_.voxelAt(n)) * 1000.0;
                if (std::fabs(p.y - middle_mm) > half_band_mm) continue;
                rib.points_mm.push_back(p);
                rib.z_mm += p.z;
            }
            if (double(rib.points_mm.size()) * mm_ * mm_ * mm_ < 2000.0) continue;
            rib.z_mm /= double(rib.points_mm.size());
            ribs.push_back(std::move(rib));
        }
        std::sort(ribs.begin(), ribs.end(),
                  [](const FlankRib& a, const FlankRib& b) { return a.z_mm > b.z_mm; });
        double narrowest = kAny, widest = 0.0;
        for (std::size_t i = 0; i + 1 < ribs.size(); ++i) {
            const double gap = gapBetween(ribs[i].points_mm, ribs[i + 1].points_mm, middle_mm);
            narrowest = std::min(narrowest, gap);
            widest = std::max(widest, gap);
        }
        line("right ribs in the flank", "", double(ribs.size()), 4, 8);
        line("narrowest intercostal gap", "mm", narrowest, 8, 25);
        line("widest intercostal gap", "mm", widest, 8, 25);
    }

    // Median of the gaps measured in planes across the band.
    double gapBetween(const std::vector<Vec3>& upper, const std::vector<Vec3>& lower,
                      double middle_mm) const {
        std::vector<double> gaps;
        for (double y = middle_mm - 24.0; y <= middle_mm + 24.0; y += 6.0) {
            double best = kAny;
            for (const Vec3& a : upper) {
                if (std::fabs(a.y - y) > mm_ * 0.5) continue;
                for (const Vec3& b : lower)
                    best = std::min(best, glm::dot(a - b, a - b));
            }
            if (best < kAny) gaps.push_back(std::sqrt(best) - mm_);
        }
        return gaps.empty() ? kAny : upperMedian(std::move(gaps));
    }

    void ductTree() {
        int narrow = 0, fit = 0;
        double widest = 0.0;
        for (const Branch& b : tubeBranches(labels_, ducts_)) {
            widest = std::max(widest, b.diameter_mm);
            if (b.diameter_mm < 3.0)
                ++narrow;
            else if (b.diameter_mm <= 8.0)
                ++fit;
        }
        line("duct branches of 3-8 mm", "", fit, 30, kAny);
        line("duct branches below 3 mm", "", narrow, 0, kAny);
        line("widest duct branch", "mm", widest, 6, 16);
        const std::vector<Offset> ball = ballOffsets(6.0 / mm_);
        std::size_t near = 0;
        for (const std::size_t n : ducts_) {
            const Index3 at = grid_.voxelAt(n);
            near += std::any_of(ball.begin(), ball.end(), [&](const Offset& o) {
                const Index3 j = at + o.step;
                return grid_.contains(j) && labels_[j] == std::uint8_t(Id::portal);
            });
        }
        line("duct within 6 mm of a portal branch", "%",
             100.0 * double(near) / double(std::max<std::size_t>(ducts_.size(), 1)), 90, 100);
        line("ducts in the liver", "ml", millilitres(ducts_.size()), 8, 120);
    }

    void pieces() {
        constexpr IdSet kWhole = kConnectedOrgans | anyOf({Id::skin, Id::fascia});
        const std::size_t pieces = connectedComponents(labels_, labelSet(kWhole)).size();
        line("islands", "", double(pieces) - std::popcount(kWhole), 0, 0);
    }

    void surfaces() {
        line("fascia: outside reached from the liver", "voxels", double(countLeakedVoxels()), 0, 0);
        std::size_t bare = 0;
        for (std::size_t n = 0; n < labels_.voxels.size(); ++n) {
            if (labels_.voxels[n] != 0) continue;
            for (const Index3& step : kFaceSteps) {
                const Index3 j = grid_.voxelAt(n) + step;
                bare += grid_.contains(j) && labels_[j] != 0 && labels_[j] != std::uint8_t(Id::skin);
            }
        }
        line("skin: body surface without it", "faces", double(bare), 0, 0);
        std::size_t cut = 0;
        for (const std::size_t n : of(Id::skin))
            cut += grid_.atSide(grid_.voxelAt(n));
        line("skin: cut off by the volume's sides", "voxels", double(cut), 0, 0);
    }

    // Floods from the liver through faces of all voxels except fascia. Returns the number of voxels
    // reached outside.
    std::size_t countLeakedVoxels() const {
        if (of(Id::liver).empty()) return 0;
        const std::size_t first = of(Id::liver).front();
        constexpr IdSet kOuter =
            anyOf({Id::air, Id::skin, Id::fat, Id::muscle, Id::ribsRight, Id::ribsLeft, Id::spine});
        std::vector<bool> seen(labels_.voxels.size(), false);
        seen[first] = true;
        std::size_t outside = 0;
        floodFaces(grid_, {grid_.voxelAt(first)}, [&](const Index3& i) {
            const std::size_t n = grid_.offset(i);
            if (seen[n] || labels_.voxels[n] == std::uint8_t(Id::fascia)) return false;
            seen[n] = true;
            outside += contains(kOuter, labels_.voxels[n]);
            return true;
        });
        return outside;
    }

    void meanHu() {
        for (const Label& l : package_.label_table) {
            double sum = 0.0;
            for (const std::size_t n : of(Id(l.id)))
                sum += package_.ct.voxels[n];
            const double table = ctRow(Id(l.id)).mean_hu;
            line("mean of " + l.name, "HU", sum / double(of(Id(l.id)).size()), table - 15.0, table + 15.0);
        }
    }

    // Looks for straight paths of at most 90 mm from the skin of the right flank to a duct at least 3 mm
    // wide that meet no risk structure.
    void flankAccess() {
        std::vector<Index3> targets;
        const std::vector<double> depth = depthInside(labels_, ducts_, 5.0);
        for (std::size_t i = 0, taken = 0; i < ducts_.size(); ++i)
            if (depth[i] >= 1.5 &&
                taken++ % std::max<std::size_t>(1, std::size_t(27.0 / (mm_ * mm_ * mm_))) == 0)
                targets.push_back(grid_.voxelAt(ducts_[i]));
        const int step = std::max(1, int(8.0 / mm_));
        int entries = 0, open = 0;
        double shortest = kAny;
        for (const std::size_t n : of(Id::skin)) {
            const Index3 at = grid_.voxelAt(n);
            if (at.y % step != 0 || at.z % step != 0 || grid_.centre(at).x < 0.09) continue;
            ++entries;
            double best = kAny;
            for (const Index3& t : targets) {
                const double length_mm = 1000.0 * glm::distance(grid_.centre(at), grid_.centre(t));
                if (length_mm <= 90.0 && length_mm < best && isPathClear(at, t)) best = length_mm;
            }
            open += best < kAny ? 1 : 0;
            shortest = std::min(shortest, best);
        }
        line("right flank: entries with a clear path", "%", 100.0 * open / std::max(entries, 1), 3, 100);
        line("right flank: shortest clear path", "mm", shortest, 20, 90);
    }

    bool isPathClear(const Index3& from, const Index3& to) const {
        for (VoxelWalk walk(grid_, grid_.centre(from), grid_.centre(to)); !walk.done(); walk.next()) {
            const std::uint8_t l = labels_[walk.voxel()];
            if (l != 0 && l <= package_.label_table.size() && package_.label_table[l - 1u].role == Role::risk)
                return false;
        }
        return true;
    }

    const Package& package_;
    const LabelVolume& labels_;
    const Grid& grid_;
    double mm_;
    std::array<std::vector<std::size_t>, std::size_t(kIdCount)> voxels_;
    std::vector<std::size_t> ducts_;  // inside the liver
    std::vector<CheckLine> lines_;
};

}  // namespace

bool isReferencePatient(const Package& package) {
    const std::vector<Label>& table = labelTable();
    const auto same = [](const Label& a, const Label& b) {
        return a.id == b.id && a.tissue == b.tissue && a.blood == b.blood && a.structure == b.structure;
    };
    if (!synthVariants(package.provenance).empty()) return false;
    return std::equal(package.label_table.begin(), package.label_table.end(), table.begin(), table.end(),
                      same);
}

std::vector<CheckLine> checkPatient(const Package& package) {
    if (!isReferencePatient(package))
        throw std::invalid_argument(package.name + " is not a reference patient");
    return Checker(package).run();
}

}  // namespace stylet::patient::synth
