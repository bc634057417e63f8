#include "xr/registration/places.h"

#include <algorithm>
#include <limits>

namespace stylet::xr::registration {

std::vector<Vec3> spreadPlaces(const Cube& cube, int count) {
    std::vector<Vec3> ways = {{-1, -1, -1}, {1, 1, -1},  {1, -1, 1},  {-1, 1, 1},
                              {1, 1, 1},    {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
    const auto add = [&](int zeros) {
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z)
                    if ((x == 0) + (y == 0) + (z == 0) == zeros) ways.emplace_back(x, y, z);
    };
    add(1);
    add(2);
    for (std::size_t corner = 0; corner < 8; ++corner)
        ways.push_back(0.5 * ways[corner]);
    std::vector<Vec3> places;
    for (int i = 0; i < std::min(count, int(ways.size())); ++i)
        places.push_back(cube.centre_m + cube.half_m * ways[std::size_t(i)]);
    return places;
}

std::string nameOfPlace(const Cube& cube, const Vec3& place_m) {
    const Vec3 way = (place_m - cube.centre_m) / cube.half_m;
    const auto side = [](double along, const char* less, const char* more) {
        return std::string(along < -0.25 ? less : along > 0.25 ? more : "");
    };
    std::string name = side(way.z, "far", "near");
    const auto add = [&](const std::string& word, const char* between) {
        if (word.empty()) return;
        name += (name.empty() ? "" : between) + word;
    };
    add(side(way.x, "left", "right"), " ");
    add(side(way.y, "low", "high"), ", ");
    return name.empty() ? "the middle" : name;
}

Vec3 nextPlace(std::span<const Vec3> places_m, std::span<const Vec3> taken_m, double near_m) {
    Vec3 best = places_m.empty() ? Vec3(0.0) : places_m.front();
    double most_m = -1.0;
    for (const Vec3& place : places_m) {
        double nearest_m = std::numeric_limits<double>::max();
        for (const Vec3& other : taken_m)
            nearest_m = std::min(nearest_m, glm::distance(place, other));
        if (nearest_m > near_m) return place;
        if (nearest_m > most_m * (1.0 + 1e-9)) best = place, most_m = nearest_m;
    }
    return best;
}

unsigned octantsReached(const Cube& cube, std::span<const Vec3> points_m) {
    unsigned reached = 0;
    for (const Vec3& p : points_m) {
        const Vec3 way = (p - cube.centre_m) / cube.half_m;
        if (std::min({std::fabs(way.x), std::fabs(way.y), std::fabs(way.z)}) < 0.25) continue;
        reached |= 1u << ((way.x > 0.0 ? 1u : 0u) + (way.y > 0.0 ? 2u : 0u) + (way.z > 0.0 ? 4u : 0u));
    }
    return reached;
}

}  // namespace stylet::xr::registration
