#include <SQLiteCpp/SQLiteCpp.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "app/records/store.h"
#include "app/report/xapi.h"
#include "patient/package/package.h"
#include "tests/app/records/some_result.h"
#include "tests/fuzz/scratch_file.h"

namespace {

using namespace stylet;

// A store with one finished attempt, and a second connection to its database.
struct StoredAttemptFixture {
    records::Store store{fuzz::scratchFolder() / "store"};
    std::string id;
    SQLite::Database raw;

    StoredAttemptFixture()
        : id(store.begin({"t1", "d", "p", "s", "exam", "0.1"})),
          raw((store.folder() / "store.sqlite").string(), SQLite::OPEN_READWRITE) {
        stylet::test::finish(store, id, {true, 50.0, 5, {{"m", "metric", "s"}}}, {{1, "cut", "liver"}});
        raw.exec("PRAGMA synchronous = OFF");
        raw.exec("PRAGMA ignore_check_constraints = ON");
    }
};

constexpr std::size_t kTexts = 15;
constexpr const char* kRow =
    "UPDATE attempt SET id = ?, trainee = ?, started_utc = ?, state = ?, device = ?, patient = ?, "
    "patient_digest = ?, scenario = ?, difficulty = ?, program_version = ?, seed = ?";
constexpr const char* kEvent = "UPDATE event SET kind = ?, text = ?";
constexpr const char* kMetric = "UPDATE metric SET id = ?, name = ?";

}  // namespace

// Writes the lines of the input to the columns of the store. The store then reads them or rejects them with a
// DataError. An attempt's folder always lies directly in the attempts folder.
// HZ-RECORD-08, HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static StoredAttemptFixture kept;
    std::vector<std::string> texts(1);
    for (std::size_t i = 0; i < size; ++i) {
        if (data[i] == '\n' && texts.size() < kTexts)
            texts.emplace_back();
        else
            texts.back() += char(data[i]);
    }
    texts.resize(kTexts);
    if (texts[0] == "-") texts[0] = kept.id;
    double number = 0.0;
    if (size >= sizeof number) std::memcpy(&number, data, sizeof number);
    {
        std::size_t next = 0;
        SQLite::Transaction change(kept.raw);
        for (const char* sql : {kRow, kEvent, kMetric}) {
            SQLite::Statement update(kept.raw, sql);
            for (int i = 1; i <= update.getBindParameterCount(); ++i)
                update.bind(i, texts[next++]);
            update.exec();
        }
        SQLite::Statement update(kept.raw, "UPDATE attempt SET dt_s = ifnull(?, 0), ticks = 5, total = ?");
        update.bind(1, number), update.bind(2, number);
        update.exec();
        change.commit();
    }
    try {
        const std::vector<records::StoredAttempt> attempts = kept.store.attempts();
        for (const records::StoredAttempt& a : attempts)
            if (a.folder.parent_path() != kept.store.folder() / "attempts" || a.folder.filename() == ".." ||
                a.folder.filename() == "." || a.folder.filename().empty())
                std::abort();
        if (report::xapiStatements(attempts, {}).empty()) std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
