#include "world/observers.h"

#include "scenario/names.h"
#include "world/assertion_checks.h"
#include "world/call.h"
#include "world/log.h"
#include "world/objects.h"
#include "world/submitted_frame.h"

namespace xrmock {

void observeState(Session& session, XrSessionState state) {
    checkStateAssertions(session.instance, state);
}

void observeFrame(Call& call, Session& session, const SubmittedFrame& frame) {
    if (runtime().log) logFrame(*runtime().log, session, frame);
    checkFrameAssertions(call, session, frame);
    if (!session.frames.begun_override.dropped) sendPictures(call, session, frame);
}

void observeRefusal(const Call& call, XrResult result, const std::string& reason) {
    if (result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST) return;
    Instance* instance = findInstance(runtime().handles.find(call.subject));
    if (instance == nullptr || instance->statistics.refusals++ > 0) return;
    instance->first_refusal = std::string(call.function) + ": " + resultName(result) + ": " + reason;
}

}  // namespace xrmock
