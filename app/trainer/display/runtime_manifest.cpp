#include "app/trainer/display/runtime_manifest.h"

#include <fstream>
#include <nlohmann/json.hpp>

namespace stylet::trainer {

namespace {
constexpr std::size_t kMaxBytes = std::size_t(1) << 20;
}

std::string readLibraryPath(std::string_view manifest) {
    const auto read = nlohmann::json::parse(manifest, nullptr, false);
    if (!read.is_object()) return {};
    const auto runtime = read.find("runtime");
    if (runtime == read.end() || !runtime->is_object()) return {};
    const auto library = runtime->find("library_path");
    if (library == runtime->end() || !library->is_string()) return {};
    return library->get<std::string>();
}

std::string readLibraryPath(const std::filesystem::path& manifest) {
    std::string text(kMaxBytes, '\0');
    std::ifstream in(manifest, std::ios::binary);
    in.read(text.data(), std::streamsize(text.size()));
    text.resize(std::size_t(in.gcount()));
    return readLibraryPath(std::string_view(text));
}

}  // namespace stylet::trainer
