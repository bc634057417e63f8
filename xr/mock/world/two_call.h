// The two-call idiom (OpenXR 1.0, "Buffer Size Parameters").
#pragma once

#include <cstdint>
#include <iterator>
#include <span>
#include <string>

#include "world/call.h"

namespace xrmock {

// With capacity 0 only the count is returned. Otherwise `write(value, element)` fills every element; if the
// buffer is too small, nothing is written.
template <class Values, class Element, class Write>
XrResult twoCall(std::uint32_t capacity, std::uint32_t* count, Element* elements, const Values& values,
                 Write write) {
    requireValid(count != nullptr, "the count output is null");
    *count = static_cast<std::uint32_t>(std::size(values));
    if (capacity == 0) return XR_SUCCESS;
    require(capacity >= *count, XR_ERROR_SIZE_INSUFFICIENT, "the buffer is too small");
    requireValid(elements != nullptr, "the buffer is null");
    for (const auto& value : values)
        write(value, *elements++);
    return XR_SUCCESS;
}

template <class Values, class Element>
XrResult twoCall(std::uint32_t capacity, std::uint32_t* count, Element* elements, const Values& values) {
    return twoCall(capacity, count, elements, values,
                   [](const auto& value, Element& element) { element = static_cast<Element>(value); });
}

// The count of a string includes the terminating null.
inline XrResult twoCallString(std::uint32_t capacity, std::uint32_t* count, char* buffer,
                              const std::string& text) {
    return twoCall(capacity, count, buffer, std::span(text.c_str(), text.size() + 1));
}

}  // namespace xrmock
