#include "world/paths.h"

#include <algorithm>

namespace xrmock {

bool isWellFormedLevel(std::string_view level) {
    const auto allowed = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.';
    };
    return std::all_of(level.begin(), level.end(), allowed) &&
           std::any_of(level.begin(), level.end(), [](char c) { return c != '.'; });
}

bool isWellFormedPath(std::string_view path) {
    if (path.empty() || path.size() >= XR_MAX_PATH_LENGTH || path.front() != '/') return false;
    while (!path.empty()) {
        path.remove_prefix(1);  // the slash
        const std::size_t end = std::min(path.find('/'), path.size());
        if (!isWellFormedLevel(path.substr(0, end))) return false;
        path.remove_prefix(end);
    }
    return true;
}

XrPath PathTable::fromString(std::string_view path) {
    const auto found = atoms_.find(path);
    if (found != atoms_.end()) return found->second;
    strings_.emplace_back(path);
    return atoms_[strings_.back()] = strings_.size();
}

const std::string* PathTable::toString(XrPath path) const {
    return path == XR_NULL_PATH || path > strings_.size() ? nullptr : &strings_[path - 1];
}

}  // namespace xrmock
