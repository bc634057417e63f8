// Handles combine a slot index and its generation, so that a destroyed or invented handle is detected and
// never dereferenced. Objects form a tree: destroying one destroys its children first.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "scenario/openxr_api.h"

namespace xrmock {

struct Object {
    explicit Object(XrObjectType object_type) : type(object_type) {}
    virtual ~Object() = default;
    Object(const Object&) = delete;
    Object& operator=(const Object&) = delete;

    XrObjectType type;
    std::uint64_t handle = 0;
    Object* parent = nullptr;  // owns this object; null for an instance
    std::vector<Object*> children;
    std::string debug_name;  // XR_EXT_debug_utils
};

class HandleTable {
  public:
    // Adds the object under `parent` and assigns its handle. Throws std::bad_alloc.
    Object& add(std::unique_ptr<Object> object, Object* parent);
    // Null if the handle was never issued or its object is destroyed.
    Object* find(std::uint64_t handle) const;
    void destroy(Object& object);

  private:
    struct Slot {
        std::unique_ptr<Object> object;
        std::uint64_t generation = 1;
    };
    std::vector<Slot> slots_;
    std::vector<std::size_t> free_;
};

// OpenXR handles are pointers on 64-bit machines and integers elsewhere.
template <class Handle>
std::uint64_t handleValue(Handle handle) {
    if constexpr (std::is_pointer_v<Handle>)
        return reinterpret_cast<std::uintptr_t>(handle);
    else
        return handle;
}

template <class Handle>
Handle toHandle(const Object& object) {
    if constexpr (std::is_pointer_v<Handle>)
        return reinterpret_cast<Handle>(static_cast<std::uintptr_t>(object.handle));
    else
        return object.handle;
}

}  // namespace xrmock
