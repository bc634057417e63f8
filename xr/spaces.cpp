#include "xr/spaces.h"

#include <algorithm>

#include "base/hex.h"

namespace stylet::xr {
namespace {

// Assumed height of LOCAL's origin above the floor if the runtime reports no floor: the eye height of a
// standing adult.
constexpr double kAssumedEyeHeight_m = 1.6;

struct Choice {
    XrReferenceSpaceType type;
    const char* name;
};
// Best first. The user cannot move the stationary space (used on request only). The user moves the stage
// only in the runtime's set-up. The recentring button moves the other two.
constexpr Choice kChoices[] = {{XR_REFERENCE_SPACE_TYPE_STATIONARY_EXT, "stationary"},
                               {XR_REFERENCE_SPACE_TYPE_STAGE, "stage"},
                               {XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT, "local_floor"},
                               {XR_REFERENCE_SPACE_TYPE_LOCAL, "local"}};

std::vector<XrReferenceSpaceType> offeredSpaces(XrSession session) {
    const char* call = "xrEnumerateReferenceSpaces";
    std::uint32_t count = 0;
    check(xrEnumerateReferenceSpaces(session, 0, &count, nullptr), call, "the runtime tracks no space");
    std::vector<XrReferenceSpaceType> offered(count);
    check(xrEnumerateReferenceSpaces(session, count, &count, offered.data()), call,
          "the runtime tracks no space");
    return offered;
}

XrResult makeReferenceSpace(XrSession session, XrReferenceSpaceType type, const Pose& reference_from_space,
                            Owned<XrSpace, xrDestroySpace>& space) {
    auto info = typed<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
    info.referenceSpaceType = type;
    info.poseInReferenceSpace = xrPoseOf(reference_from_space);
    return xrCreateReferenceSpace(session, &info, space.out());
}

std::string uuidText(const XrUuidEXT& id) {
    std::string text;
    for (std::size_t i = 0; i < 16; ++i) {
        if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
        text += hexText(id.data[i], 2);
    }
    return text;
}

}  // namespace

void Spaces::create(const Instance& instance, XrSession session, bool stationary,
                    std::vector<std::string>& notes) {
    const auto offered = offeredSpaces(session);
    XrResult made = XR_ERROR_REFERENCE_SPACE_UNSUPPORTED;
    for (const Choice& choice : kChoices) {
        if (std::find(offered.begin(), offered.end(), choice.type) == offered.end()) continue;
        if (choice.type == XR_REFERENCE_SPACE_TYPE_STATIONARY_EXT &&
            (!stationary || !instance.calls.stationaryGeneration))
            continue;
        reference_from_stage_ = {};
        if (choice.type == XR_REFERENCE_SPACE_TYPE_LOCAL)
            reference_from_stage_.position[1] = -kAssumedEyeHeight_m;
        made = makeReferenceSpace(session, choice.type, reference_from_stage_, stage_);
        if (XR_FAILED(made)) {
            notes.push_back("xrCreateReferenceSpace: " + resultName(made) +
                            ": the runtime offers the space \"" + choice.name + "\", then refuses it");
            continue;
        }
        type_ = choice.type;
        name_ = choice.name;
        break;
    }
    check(made, "xrCreateReferenceSpace", "the runtime tracks no space");
    if (type_ == XR_REFERENCE_SPACE_TYPE_LOCAL)
        notes.push_back(
            "xrEnumerateReferenceSpaces: the runtime knows no floor: it is taken to be 1.6 m below the head");
    check(makeReferenceSpace(session, XR_REFERENCE_SPACE_TYPE_VIEW, {}, head_), "xrCreateReferenceSpace",
          "the runtime does not track the head");
}

std::optional<SpaceChange> Spaces::changeOf(const XrEventDataReferenceSpaceChangePending& event) const {
    if (event.referenceSpaceType != type_) return std::nullopt;
    SpaceChange change;
    change.at_ns = event.changeTime;
    change.pose_valid = event.poseValid;
    if (event.poseValid)
        change.previous_from_new =
            inverse(reference_from_stage_) * poseOf(event.poseInPreviousSpace) * reference_from_stage_;
    return change;
}

std::string Spaces::generation(const Instance& instance, XrSession session) const {
    if (type_ != XR_REFERENCE_SPACE_TYPE_STATIONARY_EXT) return "";
    const auto info = typed<XrStationaryReferenceSpaceGenerationIdGetInfoEXT>(
        XR_TYPE_STATIONARY_REFERENCE_SPACE_GENERATION_ID_GET_INFO_EXT);
    auto id = typed<XrStationaryReferenceSpaceGenerationIdResultEXT>(
        XR_TYPE_STATIONARY_REFERENCE_SPACE_GENERATION_ID_RESULT_EXT);
    if (XR_FAILED(instance.calls.stationaryGeneration(session, &info, &id))) return "";
    return uuidText(id.generationId);
}

}  // namespace stylet::xr
