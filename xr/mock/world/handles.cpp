#include "world/handles.h"

#include <algorithm>

namespace xrmock {

namespace {
constexpr unsigned kSlotBits = 24;
constexpr std::uint64_t kSlotMask = (std::uint64_t{1} << kSlotBits) - 1;
}  // namespace

Object& HandleTable::add(std::unique_ptr<Object> object, Object* parent) {
    if (free_.empty()) {
        if (slots_.size() == kSlotMask) throw std::bad_alloc();
        slots_.emplace_back();
        free_.reserve(slots_.size());  // destroy() must not allocate
        free_.push_back(slots_.size() - 1);
    }
    Object& added = *object;
    if (parent != nullptr) parent->children.push_back(&added);
    const std::size_t slot = free_.back();
    free_.pop_back();
    added.parent = parent;
    added.handle = slots_[slot].generation << kSlotBits | (slot + 1);
    slots_[slot].object = std::move(object);
    return added;
}

Object* HandleTable::find(std::uint64_t handle) const {
    const std::uint64_t slot = (handle & kSlotMask) - 1;
    if (slot >= slots_.size() || slots_[slot].generation != handle >> kSlotBits) return nullptr;
    return slots_[slot].object.get();
}

void HandleTable::destroy(Object& object) {
    while (!object.children.empty())
        destroy(*object.children.back());
    if (object.parent != nullptr) std::erase(object.parent->children, &object);
    const std::size_t slot = (object.handle & kSlotMask) - 1;
    const std::unique_ptr<Object> doomed = std::move(slots_[slot].object);
    ++slots_[slot].generation;
    free_.push_back(slot);
}

}  // namespace xrmock
