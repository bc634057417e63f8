#include "app/modeller/motion/phases.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "app/modeller/image/handover_files.h"

namespace stylet::modeller {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMinPhases = 4, kMaxPhases = 64;
// Clamps to the values of tissue, so that metal and noise do not affect the registration.
constexpr float kMin_hu = -1000.0f, kMax_hu = 400.0f;
constexpr float kBlank_hu = 40.0f;  // outside the mask

// Sorts image2 before image10.
bool numericLess(const std::string& a, const std::string& b) {
    const auto digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
    std::size_t i = 0, k = 0;
    while (i < a.size() && k < b.size()) {
        if (digit(a[i]) && digit(b[k])) {
            std::size_t i_end = i, k_end = k;
            while (i_end < a.size() && digit(a[i_end]))
                ++i_end;
            while (k_end < b.size() && digit(b[k_end]))
                ++k_end;
            const std::string x = a.substr(i, i_end - i), y = b.substr(k, k_end - k);
            if (x.size() != y.size()) return x.size() < y.size();
            if (x != y) return x < y;
            i = i_end, k = k_end;
        } else {
            if (a[i] != b[k]) return a[i] < b[k];
            ++i, ++k;
        }
    }
    return a.size() - i < b.size() - k;
}

std::vector<fs::path> phaseFiles(const fs::path& folder) {
    std::error_code error;
    if (!fs::is_directory(folder, error))
        throw ImportError(folder.string() + ": is not a folder; name the folder of the phases");
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        if (name.starts_with('.')) continue;
        if (entry.is_directory() || name.ends_with(".dcm") || name.ends_with(".nii") ||
            name.ends_with(".nii.gz"))
            files.push_back(entry.path());
        if (files.size() > kMaxPhases)
            throw ImportError(folder.string() + ": more than " + std::to_string(kMaxPhases) + " phases");
    }
    if (files.size() < kMinPhases)
        throw ImportError(folder.string() + ": " + std::to_string(files.size()) +
                          " phases; a fit needs four, each a file (.dcm, .nii, .nii.gz) or a folder");
    std::sort(files.begin(), files.end(),
              [](const fs::path& a, const fs::path& b) { return numericLess(a.filename(), b.filename()); });
    return files;
}

FloatVolume toHu(const Volume<std::int16_t>& stored, double spacing_mm) {
    FloatVolume hu(stored.grid);
    if (spacing_mm > 0.0) hu.grid.spacing_m = Vec3(1e-3 * spacing_mm);
    const bool has_offset = *std::min_element(stored.voxels.begin(), stored.voxels.end()) >= 0;
    for (std::size_t i = 0; i < stored.voxels.size(); ++i)
        hu.voxels[i] = float(stored.voxels[i]) - (has_offset ? 1000.0f : 0.0f);
    return hu;
}

}  // namespace

std::vector<Phase> readPhases(const PhaseSettings& settings) {
    std::vector<Phase> phases;
    for (const fs::path& file : phaseFiles(settings.folder)) {
        Phase phase;
        phase.name = file.filename().string();
        phase.hu = toHu(readImage(file, ImageKind::phase, settings.reader), settings.spacing_mm);
        if (!phases.empty() && !(phase.hu.grid == phases.front().hu.grid))
            throw ImportError(file.string() + ": its grid is not that of " + phases.front().name);
        phases.push_back(std::move(phase));
        settings.progress("read " + phases.back().name);
    }
    return phases;
}

VectorField registerPhases(const FloatVolume& fixed, const FloatVolume& moving, const Mask& mask,
                           const RegisterSettings& settings) {
    const PrivateFolder folder;
    const auto at = [&](const char* name) { return folder.path() / name; };
    Volume<std::int16_t> voxels(fixed.grid);
    for (const auto& [name, image] : {std::pair{"fixed", &fixed}, std::pair{"moving", &moving}}) {
        for (std::size_t i = 0; i < voxels.voxels.size(); ++i) {
            const float hu = mask.voxels[i] ? std::clamp(image->voxels[i], kMin_hu, kMax_hu) : kBlank_hu;
            voxels.voxels[i] = std::int16_t(std::lround(hu));
        }
        writeImageFile(at(name), voxels);
    }
    for (std::size_t i = 0; i < voxels.voxels.size(); ++i)
        voxels.voxels[i] = mask.voxels[i] != 0;
    writeImageFile(at("mask"), voxels);
    runChild(childProgram(settings.program, "stylet-register"),
             {"phases", at("fixed"), at("moving"), at("mask"), at("field"), std::to_string(settings.finest)},
             settings.limits, "phases", "the registration");
    return readFieldFile(at("field"));
}

}  // namespace stylet::modeller
