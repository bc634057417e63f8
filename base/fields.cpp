#include "base/fields.h"

#include <fmt/format.h>
#include <toml++/toml.h>
#include <map>
#include <nlohmann/json.hpp>
#include <variant>

#include "base/hex.h"

namespace stylet {

struct FieldNode {
    using List = std::vector<FieldNode>;
    using Table = std::map<std::string, FieldNode, std::less<>>;

    // std::uint64_t only for numbers that std::int64_t cannot represent.
    std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string, List, Table> value;
};

struct FieldFile {
    std::filesystem::path path;
    const char* not_a_table = "not a table";
    FieldNode root{};
    std::vector<std::string> repeated{};
};

namespace {

constexpr int kMaxNesting = 64;

// Builds the nodes of a JSON text; called by nlohmann's parser.
class JsonNodes {
  public:
    using Json = nlohmann::json;

    explicit JsonNodes(FieldFile& file) : file_(file) {}

    bool null() { return add({}); }
    bool boolean(bool v) { return add({v}); }
    bool number_integer(Json::number_integer_t v) { return add({std::int64_t(v)}); }
    bool number_unsigned(Json::number_unsigned_t v) {
        return v <= std::uint64_t(INT64_MAX) ? add({std::int64_t(v)}) : add({std::uint64_t(v)});
    }
    bool number_float(Json::number_float_t v, const std::string&) { return add({v}); }
    bool string(std::string& v) { return add({std::move(v)}); }
    bool binary(Json::binary_t&) { return false; }  // JSON text has no binary values
    bool start_object(std::size_t) { return open({FieldNode::Table()}); }
    bool start_array(std::size_t) { return open({FieldNode::List()}); }
    bool end_object() { return close(); }
    bool end_array() { return close(); }
    bool key(std::string& key) {
        if (std::get<FieldNode::Table>(open_.back()->value).contains(key)) file_.repeated.push_back(key);
        key_ = std::move(key);
        return true;
    }
    bool parse_error(std::size_t, const std::string&, const Json::exception& e) {
        const std::string text = e.what();  // "[json.exception.parse_error.101] parse error at line 1, ..."
        throw DataError(file_.path, "json", text.substr(text.find(']') + 2));
    }

  private:
    FieldNode& place(FieldNode node) {
        if (open_.empty()) return file_.root = std::move(node);
        if (auto* list = std::get_if<FieldNode::List>(&open_.back()->value))
            return list->emplace_back(std::move(node));
        return std::get<FieldNode::Table>(open_.back()->value)[key_] = std::move(node);
    }
    bool add(FieldNode node) {
        place(std::move(node));
        return true;
    }
    bool open(FieldNode node) {
        if (open_.size() == kMaxNesting) throw DataError(file_.path, "json", "nested too deeply");
        open_.push_back(&place(std::move(node)));
        return true;
    }
    bool close() {
        open_.pop_back();
        return true;
    }

    FieldFile& file_;
    std::vector<FieldNode*> open_;
    std::string key_;
};

FieldNode nodeFromToml(const toml::node& from, const std::filesystem::path& file, int depth = 0) {
    if (depth > kMaxNesting) throw DataError(file, "toml", "nested too deeply");
    if (const auto* v = from.as_boolean()) return {v->get()};
    if (const auto* v = from.as_integer()) return {v->get()};
    if (const auto* v = from.as_floating_point()) return {v->get()};
    if (const auto* v = from.as_string()) return {v->get()};
    if (const toml::array* elements = from.as_array()) {
        FieldNode::List list;
        for (const toml::node& element : *elements)
            list.push_back(nodeFromToml(element, file, depth + 1));
        return {std::move(list)};
    }
    if (!from.is_table()) return {};
    FieldNode::Table table;
    for (const auto& [key, member] : *from.as_table())
        table.emplace(key.str(), nodeFromToml(member, file, depth + 1));
    return {std::move(table)};
}

}  // namespace

Fields::Fields(std::unique_ptr<const FieldFile> file) : Fields(*file, "", file->root) {
    owned_ = std::move(file);
}
Fields::Fields(const FieldFile& file, std::string field, const FieldNode& node)
    : file_(&file), field_(std::move(field)), node_(&node) {
    if (!std::holds_alternative<FieldNode::Table>(node.value))
        throw DataError(file.path, field_.empty() ? "json" : field_, file.not_a_table);
}
Fields::Fields(Fields&&) noexcept = default;
Fields::~Fields() = default;

const std::filesystem::path& Fields::file() const {
    return file_->path;
}

FieldKind Fields::kind(std::string_view key) const {
    const auto& table = std::get<FieldNode::Table>(node_->value);
    const auto found = table.find(key);
    if (found == table.end()) return FieldKind::absent;
    constexpr FieldKind kKinds[] = {FieldKind::null,   FieldKind::flag, FieldKind::number, FieldKind::number,
                                    FieldKind::number, FieldKind::text, FieldKind::list,   FieldKind::table};
    return kKinds[found->second.value.index()];
}

std::string Fields::fullKey(std::string_view key) const {
    return field_.empty() ? std::string(key) : fmt::format("{}.{}", field_, key);
}

void Fields::refuse(std::string_view key, const std::string& reason) const {
    throw DataError(file_->path, fullKey(key), reason);
}

const FieldNode& Fields::read(std::string_view key) {
    const auto& table = std::get<FieldNode::Table>(node_->value);
    const auto found = table.find(key);
    if (found == table.end()) refuse(key, "missing");
    read_.insert(&found->second);
    return found->second;
}

double Fields::toNumber(const FieldNode& node, std::string_view key, double low, double high) const {
    double value = 0.0;
    if (const auto* v = std::get_if<double>(&node.value))
        value = *v;
    else if (const auto* i = std::get_if<std::int64_t>(&node.value))
        value = double(*i);
    else if (const auto* u = std::get_if<std::uint64_t>(&node.value))
        value = double(*u);
    else
        refuse(key, "not a number");
    if (!(value >= low && value <= high))
        refuse(key, fmt::format("{:g} is not in [{:g}, {:g}]", value, low, high));
    return value;
}

std::int64_t Fields::toInteger(const FieldNode& node, std::string_view key, std::int64_t low,
                               std::int64_t high) const {
    const auto* value = std::get_if<std::int64_t>(&node.value);
    if (!value) refuse(key, "not an integer");
    if (*value < low || *value > high) refuse(key, fmt::format("{} is not in [{}, {}]", *value, low, high));
    return *value;
}

const std::string& Fields::toText(const FieldNode& node, std::string_view key, std::size_t max_bytes) const {
    const auto* value = std::get_if<std::string>(&node.value);
    if (!value) refuse(key, "not a string");
    if (value->size() > max_bytes) refuse(key, fmt::format("longer than {} bytes", max_bytes));
    return *value;
}

std::uint64_t Fields::count(std::string_view key) {
    const FieldNode& node = read(key);
    if (const auto* large = std::get_if<std::uint64_t>(&node.value)) return *large;
    return std::uint64_t(toInteger(node, key, 0, INT64_MAX));
}

std::uint64_t Fields::hex(std::string_view key) {
    const std::optional<std::uint64_t> value = parseHex(toText(read(key), key, kMaxTextBytes));
    if (!value) refuse(key, "not 16 hexadecimal digits");
    return *value;
}

bool Fields::flag(std::string_view key) {
    const auto* value = std::get_if<bool>(&read(key).value);
    if (!value) refuse(key, "not true or false");
    return *value;
}

std::string Fields::nonEmptyText(std::string_view key, std::size_t max_bytes) {
    std::string value = text(key, max_bytes);
    if (value.empty()) refuse(key, "empty");
    return value;
}

std::size_t Fields::readChoice(std::string_view key, std::span<const std::string_view> names) {
    const std::string name = text(key);
    for (std::size_t i = 0; i < names.size(); ++i)
        if (names[i] == name) return i;
    refuse(key, fmt::format("\"{}\" is not one of {}", name.substr(0, 40), fmt::join(names, ", ")));
}

const std::vector<FieldNode>& Fields::readList(std::string_view key, std::size_t max_count) {
    const auto* list = std::get_if<FieldNode::List>(&read(key).value);
    if (!list) refuse(key, "not an array");
    if (list->size() > max_count) refuse(key, fmt::format("more than {} entries", max_count));
    return *list;
}

void Fields::readNumbers(std::string_view key, double low, double high, std::span<double> values) {
    const auto* list = std::get_if<FieldNode::List>(&read(key).value);
    if (!list || list->size() != values.size()) refuse(key, fmt::format("not {} numbers", values.size()));
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = toNumber((*list)[i], key, low, high);
}

std::vector<std::int64_t> Fields::integers(std::string_view key, std::int64_t low, std::int64_t high,
                                           std::size_t max_count) {
    std::vector<std::int64_t> values;
    for (const FieldNode& element : readList(key, max_count))
        values.push_back(toInteger(element, key, low, high));
    return values;
}

std::vector<std::string> Fields::texts(std::string_view key, std::size_t max_count, std::size_t max_bytes) {
    std::vector<std::string> values;
    for (const FieldNode& element : readList(key, max_count))
        values.push_back(toText(element, key, max_bytes));
    return values;
}

Fields Fields::child(std::string_view key) {
    return {*file_, fullKey(key), read(key)};
}

Fields Fields::childOrEmpty(std::string_view key) {
    static const FieldNode none{FieldNode::Table()};
    return {*file_, fullKey(key), has(key) ? read(key) : none};
}

std::vector<Fields> Fields::children(std::string_view key, std::size_t max_count) {
    std::vector<Fields> readers;
    for (const FieldNode& element : readList(key, max_count))
        readers.push_back({*file_, fmt::format("{}[{}]", fullKey(key), readers.size()), element});
    return readers;
}

void Fields::finish() const {
    for (const auto& [key, node] : std::get<FieldNode::Table>(node_->value))
        if (!read_.contains(&node)) refuse(key, "unknown key");
}

const std::vector<std::string>& Fields::duplicateKeys() const {
    return file_->repeated;
}

Fields parseToml(const std::filesystem::path& file, std::string_view text) {
    try {
        FieldFile parsed{.path = file, .root = nodeFromToml(toml::parse(text), file)};
        return Fields(std::make_unique<const FieldFile>(std::move(parsed)));
    } catch (const toml::parse_error& e) {
        throw DataError(file, fmt::format("line {}", e.source().begin.line), std::string(e.description()));
    }
}

Fields parseJson(const std::filesystem::path& file, std::string_view text) {
    FieldFile parsed{.path = file, .not_a_table = "not an object"};
    JsonNodes nodes(parsed);
    nlohmann::json::sax_parse(text, &nodes);
    return Fields(std::make_unique<const FieldFile>(std::move(parsed)));
}

}  // namespace stylet
