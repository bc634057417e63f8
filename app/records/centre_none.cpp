// Built without PostgreSQL.
#include "app/records/centre.h"

namespace stylet::records {

struct Centre::Connection {};

Centre::Centre(const std::string&, std::function<void(int)>) {
    throw std::runtime_error("this program was built without PostgreSQL");
}

Centre::~Centre() = default;

void Centre::insert(const StoredAttempt&, const std::vector<StoredFile>&) {}

void Centre::erase(const std::string&) {}

bool hasCentre() {
    return false;
}

}  // namespace stylet::records
