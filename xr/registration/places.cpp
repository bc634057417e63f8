#include "xr/registration/places.h"

#include <algorithm>
#include <limits>

namespace stylet::xr::registration {

std::vector<Vec3> chooseTouchPlaces(const Cube& cube, int count) {
    std::vector<Vec3> directions = {{-1, -1, -1}, {1, 1, -1},  {1, -1, 1},  {-1, 1, 1},
                                    {1, 1, 1},    {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
    const auto add = [&](int zeros) {
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z)
                    if ((x == 0) + (y == 0) + (z == 0) == zeros) directions.emplace_back(x, y, z);
    };
    add(1);
    add(2);
    for (std::size_t corner = 0; corner < 8; ++corner)
        directions.push_back(0.5 * directions[corner]);
    std::vector<Vec3> places;
    for (int i = 0; i < std::min(count, int(directions.size())); ++i)
        places.push_back(cube.centre_m + cube.half_m * directions[std::size_t(i)]);
    return places;
}

std::string describePlace(const Cube& cube, const Vec3& place_m) {
    const Vec3 direction = (place_m - cube.centre_m) / cube.half_m;
    const auto side = [](double along, const char* less, const char* more) {
        return std::string(along < -0.25 ? less : along > 0.25 ? more : "");
    };
    std::string name = side(direction.z, "far", "near");
    const auto add = [&](const std::string& word, const char* between) {
        if (word.empty()) return;
        name += (name.empty() ? "" : between) + word;
    };
    add(side(direction.x, "left", "right"), " ");
    add(side(direction.y, "low", "high"), ", ");
    return name.empty() ? "the middle" : name;
}

Vec3 nextPlace(std::span<const Vec3> places_m, std::span<const Vec3> touched_m, double near_m) {
    Vec3 best = places_m.empty() ? Vec3(0.0) : places_m.front();
    double farthest_m = -1.0;
    for (const Vec3& place : places_m) {
        double nearest_m = std::numeric_limits<double>::max();
        for (const Vec3& other : touched_m)
            nearest_m = std::min(nearest_m, glm::distance(place, other));
        if (nearest_m > near_m) return place;
        if (nearest_m > farthest_m * (1.0 + 1e-9)) best = place, farthest_m = nearest_m;
    }
    return best;
}

unsigned octantsReached(const Cube& cube, std::span<const Vec3> points_m) {
    unsigned reached = 0;
    for (const Vec3& p : points_m) {
        const Vec3 direction = (p - cube.centre_m) / cube.half_m;
        if (std::min({std::fabs(direction.x), std::fabs(direction.y), std::fabs(direction.z)}) < 0.25)
            continue;
        reached |= 1u << ((direction.x > 0.0 ? 1u : 0u) + (direction.y > 0.0 ? 2u : 0u) +
                          (direction.z > 0.0 ? 4u : 0u));
    }
    return reached;
}

}  // namespace stylet::xr::registration
