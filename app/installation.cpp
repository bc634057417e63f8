#include "app/installation.h"

#include <cstdlib>

#include "patient/package/package.h"

namespace stylet {

namespace fs = std::filesystem;

fs::path programFile() {
    return fs::read_symlink("/proc/self/exe");
}

fs::path programFolder() {
    return programFile().parent_path();
}

fs::path assetsFolder() {
    if (const char* named = std::getenv("STYLET_ASSETS"); named && *named) return named;
    const fs::path bin = programFolder();
    // Installed: <prefix>/bin and <prefix>/share; built: <source>/build/<preset>/bin.
    for (const fs::path& folder :
         {bin.parent_path() / "share" / "stylet" / "assets", bin / ".." / ".." / ".." / "assets"})
        if (fs::exists(folder / "scenarios")) return fs::weakly_canonical(folder);
    throw DataError("assets", "folder", "not found beside " + bin.string() + "; name it in STYLET_ASSETS");
}

}  // namespace stylet
