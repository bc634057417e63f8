// Strict reader of TOML and JSON files. Every error is a DataError with the file, the field ("label[3].id")
// and the reason.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/errors.h"
#include "base/geometry.h"

namespace stylet {

struct FieldFile;
struct FieldNode;

// A date in TOML counts as null.
enum class FieldKind { absent, null, flag, number, text, list, table };

// One table (in JSON: object). The `Fields` object that a parser returns owns the whole file; its children
// are valid as long as it lives. Reading an absent key throws, unless the function's comment says otherwise.
class Fields {
  public:
    static constexpr std::size_t kMaxTextBytes = 1 << 16;
    static constexpr double kUnlimited = std::numeric_limits<double>::infinity();

    explicit Fields(std::unique_ptr<const FieldFile> file);  // for the parsers below
    Fields(Fields&&) noexcept;
    ~Fields();

    const std::filesystem::path& file() const;
    FieldKind kind(std::string_view key) const;
    bool has(std::string_view key) const { return kind(key) != FieldKind::absent; }
    [[noreturn]] void refuse(std::string_view key, const std::string& reason) const;

    // Limits are inclusive. number() also accepts an integer. NaN is never within limits. The ...Or()
    // functions return `absent` if the key is absent.
    double number(std::string_view key, double low = -kUnlimited, double high = kUnlimited) {
        return toNumber(read(key), key, low, high);
    }
    double numberOr(std::string_view key, double low, double high, double absent) {
        return has(key) ? number(key, low, high) : absent;
    }
    std::int64_t integer(std::string_view key, std::int64_t low, std::int64_t high) {
        return toInteger(read(key), key, low, high);
    }
    std::uint64_t count(std::string_view key);  // any unsigned integer
    std::uint64_t hex(std::string_view key);    // a text of 16 hexadecimal digits
    bool flag(std::string_view key);
    std::string text(std::string_view key, std::size_t max_bytes = kMaxTextBytes) {
        return toText(read(key), key, max_bytes);
    }
    std::string textOr(std::string_view key, const std::string& absent,
                       std::size_t max_bytes = kMaxTextBytes) {
        return has(key) ? text(key, max_bytes) : absent;
    }
    std::string nonEmptyText(std::string_view key, std::size_t max_bytes = kMaxTextBytes);
    // The value of an enumeration whose names, in order, are `names`.
    template <typename Enum>
    Enum choice(std::string_view key, std::span<const std::string_view> names) {
        return Enum(readChoice(key, names));
    }

    // Lists. The limits apply to each element.
    template <std::size_t N>
    std::array<double, N> numbers(std::string_view key, double low = -kUnlimited, double high = kUnlimited) {
        std::array<double, N> values{};
        readNumbers(key, low, high, values);
        return values;
    }
    Vec3 vector(std::string_view key, double low = -kUnlimited, double high = kUnlimited) {
        const auto v = numbers<3>(key, low, high);
        return {v[0], v[1], v[2]};
    }
    std::vector<std::int64_t> integers(std::string_view key, std::int64_t low, std::int64_t high,
                                       std::size_t max_count);
    std::vector<std::string> texts(std::string_view key, std::size_t max_count,
                                   std::size_t max_bytes = kMaxTextBytes);

    Fields child(std::string_view key);
    Fields childOrEmpty(std::string_view key);  // an empty table if the key is absent
    // The elements of a list of tables.
    std::vector<Fields> children(std::string_view key, std::size_t max_count);
    std::vector<Fields> childrenOrNone(std::string_view key, std::size_t max_count) {
        return has(key) ? children(key, max_count) : std::vector<Fields>();
    }

    void ignore(std::string_view key) {  // finish() accepts this key
        if (has(key)) read(key);
    }
    void finish() const;  // throws if the table has keys that were never read
    // Keys that occur twice in a JSON object, anywhere in the file. The last value counts.
    const std::vector<std::string>& duplicateKeys() const;

  private:
    Fields(const FieldFile& file, std::string field, const FieldNode& node);
    std::string fullKey(std::string_view key) const;
    const FieldNode& read(std::string_view key);
    std::size_t readChoice(std::string_view key, std::span<const std::string_view> names);
    const std::vector<FieldNode>& readList(std::string_view key, std::size_t max_count);
    void readNumbers(std::string_view key, double low, double high, std::span<double> values);
    double toNumber(const FieldNode& node, std::string_view key, double low, double high) const;
    std::int64_t toInteger(const FieldNode& node, std::string_view key, std::int64_t low,
                           std::int64_t high) const;
    const std::string& toText(const FieldNode& node, std::string_view key, std::size_t max_bytes) const;

    std::unique_ptr<const FieldFile> owned_;
    const FieldFile* file_;
    std::string field_;
    const FieldNode* node_;
    std::set<const FieldNode*> read_;
};

// The DataError of a syntax error names the line in TOML, and the field "json" in JSON. `file` is used for
// messages only.
Fields parseToml(const std::filesystem::path& file, std::string_view text);
Fields parseJson(const std::filesystem::path& file, std::string_view text);

}  // namespace stylet
