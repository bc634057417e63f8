#include "observers.h"

#include "call.h"
#include "log.h"
#include "names.h"
#include "objects.h"
#include "submitted_frame.h"

namespace xrmock {

void observeState(Session&, XrSessionState, std::int64_t) {}

void observeFrame(Call& call, Session& session, const SubmittedFrame& frame) {
    if (runtime().log) logFrame(*runtime().log, session, frame);
    servePictures(call, session, frame);
}

void observeRefusal(const Call& call, XrResult result, const std::string&) {
    if (result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST) return;
    Object* subject = runtime().handles.find(call.subject);
    if (subject != nullptr) ++const_cast<Instance*>(instanceOf(subject))->statistics.refusals;
}

}  // namespace xrmock
