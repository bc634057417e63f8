#include "xr/spaces.h"

#include <fmt/core.h>

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
// Most stable first. The user cannot move the stationary space (used on request only). The user moves the
// stage only in the runtime's set-up. The recentring button moves the other two.
constexpr Choice kChoices[] = {{XR_REFERENCE_SPACE_TYPE_STATIONARY_EXT, "stationary"},
                               {XR_REFERENCE_SPACE_TYPE_STAGE, "stage"},
                               {XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT, "local_floor"},
                               {XR_REFERENCE_SPACE_TYPE_LOCAL, "local"}};

std::vector<XrReferenceSpaceType> offeredSpaces(XrSession session) {
    return enumerate<XrReferenceSpaceType>(
        "xrEnumerateReferenceSpaces", "the runtime offers no tracked space",
        [&](auto... out) { return xrEnumerateReferenceSpaces(session, out...); });
}

XrResult makeReferenceSpace(XrSession session, XrReferenceSpaceType type, const Pose& reference_from_space,
                            Owned<XrSpace, xrDestroySpace>& space) {
    auto info = makeStruct<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
    info.referenceSpaceType = type;
    info.poseInReferenceSpace = toXrPose(reference_from_space);
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
            (!stationary || !instance.calls.getStationaryGenerationId))
            continue;
        reference_from_stage_ = {};
        if (choice.type == XR_REFERENCE_SPACE_TYPE_LOCAL)
            reference_from_stage_.position_m.y = -kAssumedEyeHeight_m;
        made = makeReferenceSpace(session, choice.type, reference_from_stage_, stage_);
        if (XR_FAILED(made)) {
            notes.push_back(fmt::format(
                "xrCreateReferenceSpace: {}: the runtime offers the space \"{}\", then refuses it",
                resultName(made), choice.name));
            continue;
        }
        type_ = choice.type;
        name_ = choice.name;
        break;
    }
    check(made, "xrCreateReferenceSpace", "the runtime offers no tracked space");
    if (type_ == XR_REFERENCE_SPACE_TYPE_LOCAL)
        notes.push_back(
            "xrEnumerateReferenceSpaces: the runtime reports no floor: it is assumed 1.6 m below the head");
    check(makeReferenceSpace(session, XR_REFERENCE_SPACE_TYPE_VIEW, {}, head_), "xrCreateReferenceSpace",
          "the runtime does not track the head");
}

std::optional<SpaceChange> Spaces::toSpaceChange(const XrEventDataReferenceSpaceChangePending& event) const {
    if (event.referenceSpaceType != type_) return std::nullopt;
    SpaceChange change;
    change.at_ns = event.changeTime;
    change.pose_valid = event.poseValid;
    if (event.poseValid)
        change.previous_from_new =
            reference_from_stage_.inverse() * toPose(event.poseInPreviousSpace) * reference_from_stage_;
    return change;
}

std::string Spaces::generation(const Instance& instance, XrSession session) const {
    if (type_ != XR_REFERENCE_SPACE_TYPE_STATIONARY_EXT) return "";
    const auto info = makeStruct<XrStationaryReferenceSpaceGenerationIdGetInfoEXT>(
        XR_TYPE_STATIONARY_REFERENCE_SPACE_GENERATION_ID_GET_INFO_EXT);
    auto id = makeStruct<XrStationaryReferenceSpaceGenerationIdResultEXT>(
        XR_TYPE_STATIONARY_REFERENCE_SPACE_GENERATION_ID_RESULT_EXT);
    if (XR_FAILED(instance.calls.getStationaryGenerationId(session, &info, &id))) return "";
    return uuidText(id.generationId);
}

}  // namespace stylet::xr
