#include "patient/contrast/contrast_fill.h"

#include <cmath>
#include <cstddef>

namespace stylet::patient {

FillOrder::FillOrder(std::span<const double> path_m, std::span<const double> capacity_m3) {
    // Entries of equal distance keep their input order.
    struct Place {
        double path_m;
        std::size_t number;
    };
    std::vector<Place> places;
    places.reserve(path_m.size());
    for (std::size_t i = 0; i < path_m.size(); ++i)
        if (std::isfinite(path_m[i]) && capacity_m3[i] > 0.0) places.push_back({path_m[i], i});
    std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
        return a.path_m < b.path_m || (a.path_m == b.path_m && a.number < b.number);
    });
    path_m_.reserve(places.size()), capacity_m3_.reserve(places.size() + 1),
        moment_m4_.reserve(places.size() + 1);
    capacity_m3_.push_back(0.0), moment_m4_.push_back(0.0);
    for (const Place& place : places) {
        path_m_.push_back(place.path_m);
        capacity_m3_.push_back(capacity_m3_.back() + capacity_m3[place.number]);
        moment_m4_.push_back(moment_m4_.back() + capacity_m3[place.number] * place.path_m);
    }
}

double FillOrder::filled(const FrontShape& front, double front_m) const noexcept {
    const double width_m = front.widthAt(front_m);
    const auto countBelow = [&](double path) {
        return std::size_t(std::lower_bound(path_m_.begin(), path_m_.end(), path) - path_m_.begin());
    };
    const std::size_t full = countBelow(front_m - 0.5 * width_m), begun = countBelow(front_m + 0.5 * width_m);
    const double room = capacity_m3_[begun] - capacity_m3_[full],
                 moment = moment_m4_[begun] - moment_m4_[full];
    return capacity_m3_[full] + (front_m / width_m + 0.5) * room - moment / width_m;
}

double FillOrder::frontPosition_m(const FrontShape& front, double volume_m3) const noexcept {
    if (path_m_.empty()) return 0.0;
    double low = -0.5 * front.width_m, high = low + 1e-3;
    while (filled(front, high) < volume_m3 && high < 1e3)
        high = 2.0 * (high + 0.5 * front.width_m);
    for (int i = 0; i < 60 && high - low > 1e-12; ++i) {
        const double middle = 0.5 * (low + high);
        (filled(front, middle) < volume_m3 ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

}  // namespace stylet::patient
