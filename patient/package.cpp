#include "patient/package.h"

#include "patient/package_toml.h"
#include "patient/toml_reader.h"

namespace stylet::patient {

TissueDefaults loadTissueDefaults(const std::filesystem::path& toml) {
    return parseTissueDefaults(toml, readTextFile(toml, kMaxTomlBytes));
}

}  // namespace stylet::patient
