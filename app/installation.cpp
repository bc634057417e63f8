#include "app/installation.h"

#include <cstdlib>
#include <set>

#include "patient/package/package.h"

namespace stylet {

namespace fs = std::filesystem;

fs::path programFile() {
    return fs::read_symlink("/proc/self/exe");
}

fs::path programFolder() {
    return programFile().parent_path();
}

namespace {

bool holdsAssets(const fs::path& folder) {
    std::error_code unreadable;
    return fs::exists(folder / "difficulty.toml", unreadable);
}

}  // namespace

fs::path assetsFolder() {
    if (const char* named = std::getenv("STYLET_ASSETS"); named && *named) {
        if (!holdsAssets(named))
            throw DataError("STYLET_ASSETS", named, "is not the assets folder: it has no difficulty.toml");
        return named;
    }
    const fs::path bin = programFolder();
    // Installed: <prefix>/bin and <prefix>/share; built: <source>/build/<preset>/bin.
    for (const fs::path& folder :
         {bin.parent_path() / "share" / "stylet" / "assets", bin / ".." / ".." / ".." / "assets"})
        if (holdsAssets(folder)) return fs::weakly_canonical(folder);
    throw DataError("assets", "folder", "not found beside " + bin.string() + "; name it in STYLET_ASSETS");
}

fs::path assetFile(const std::string& kind, const std::string& name) {
    if (name.ends_with(".toml")) return name;
    const fs::path folder = assetsFolder() / (kind + "s"), file = folder / (name + ".toml");
    if (fs::exists(file)) return file;
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.path().extension() == ".toml") names.insert(entry.path().stem());
    std::string list;
    for (const std::string& one : names)
        list += (list.empty() ? "" : ", ") + one;
    throw DataError(folder, kind + " \"" + name + "\"", "not among: " + list);
}

}  // namespace stylet
