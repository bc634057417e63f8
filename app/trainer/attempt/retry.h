// Restarts an earlier attempt at a bookmark. The recorded inputs up to the bookmark are recomputed and
// checked, then new input takes over.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "app/records/record.h"
#include "app/trainer/attempt/attempt.h"
#include "app/training/patient_case.h"
#include "app/training/progress.h"

namespace stylet::trainer {

struct Retry {
    std::filesystem::path folder;  // folder of the record
    records::Record record;        // up to the bookmark
    records::Bookmark bookmark;
    std::size_t number = 0;  // number of the bookmark, from 1
    // Last recorded tick before the bookmark; set by checkRetry().
    haptics::TickOutput left;
};

// The course that a record names. Throws DataError.
training::Course recordedCourse(const records::RecordInfo&);

// Its case; null: it had none. Throws DataError.
std::shared_ptr<const training::PatientCase> recordedCase(const records::RecordInfo&);

// `from`: ATTEMPT[@BOOKMARK]. ATTEMPT is an attempt's folder, a record's folder, or an attempt's id in
// `store`. BOOKMARK is a number from 1 or the bookmark's text; default: the last one. Throws DataError that
// lists the available bookmarks.
Retry openRetry(const std::string& from, const std::filesystem::path& store);

// Recomputes the record up to the bookmark. Throws DataError if it belongs to another patient or the result
// differs from the record.
void checkRetry(Retry&, const patient::Patient&, const MakeTouch& = makeTouch);

// Makes the attempt begin with the recorded settings and inputs. Converts scripted input to the device frame
// of the record.
void startFromRecord(Attempt&, const Retry&, const MakeTouch& = makeTouch);

// Compares the numbers of two device profiles on which the force depends. Returns false if the recorded force
// settings do not suit the device.
bool haveSameForceLimits(const haptics::DeviceProfile&, const haptics::DeviceProfile&);

}  // namespace stylet::trainer
