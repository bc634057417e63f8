#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "api/api.h"
#include "world/objects.h"
#include "world/spaces.h"
#include "world/two_call.h"
#include "world/verify.h"

namespace xrmock {

namespace {

std::vector<XrReferenceSpaceType> referenceSpaces(const Instance& instance) {
    const Offers& offers = instance.scenario.offers;
    std::vector<XrReferenceSpaceType> types{XR_REFERENCE_SPACE_TYPE_VIEW, XR_REFERENCE_SPACE_TYPE_LOCAL};
    if (offers.stage) types.push_back(XR_REFERENCE_SPACE_TYPE_STAGE);
    if (offers.local_floor && instance.extensions.contains(XR_EXT_LOCAL_FLOOR_EXTENSION_NAME))
        types.push_back(XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT);
    if (offers.stationary && instance.extensions.contains(XR_EXT_STATIONARY_REFERENCE_SPACE_EXTENSION_NAME))
        types.push_back(XR_REFERENCE_SPACE_TYPE_STATIONARY_EXT);
    return types;
}

bool offersReferenceSpace(const Instance& instance, XrReferenceSpaceType type) {
    const auto offered = referenceSpaces(instance);
    return std::find(offered.begin(), offered.end(), type) != offered.end();
}

}  // namespace

XrResult enumerateReferenceSpaces(Call& call, XrSession handle, std::uint32_t capacity, std::uint32_t* count,
                                  XrReferenceSpaceType* types) {
    const Session& session = call.live<Session>(handle);
    return twoCall(capacity, count, types, referenceSpaces(session.instance));
}

XrResult createReferenceSpace(Call& call, XrSession handle, const XrReferenceSpaceCreateInfo* info,
                              XrSpace* out) {
    Session& session = call.live<Session>(handle);
    requireStruct(info, XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
    requireValid(out != nullptr, "space is null");
    require(offersReferenceSpace(session.instance, info->referenceSpaceType),
            XR_ERROR_REFERENCE_SPACE_UNSUPPORTED, "the session has no such reference space");
    require(isValid(info->poseInReferenceSpace), XR_ERROR_POSE_INVALID, "poseInReferenceSpace is not a pose");
    auto space = std::make_unique<Space>(session);
    space->reference = info->referenceSpaceType;
    space->origin_from_space = fromXr(info->poseInReferenceSpace);
    *out = toHandle<XrSpace>(call.create(std::move(space), &session));
    return XR_SUCCESS;
}

XrResult getReferenceSpaceBoundsRect(Call& call, XrSession handle, XrReferenceSpaceType type,
                                     XrExtent2Df* bounds) {
    const Session& session = call.live<Session>(handle);
    requireValid(bounds != nullptr, "bounds is null");
    // Rejects types of extensions that are not enabled, unknown types, and types that the scenario does not
    // offer.
    requireValid(offersReferenceSpace(session.instance, type), "the session has no such reference space");
    *bounds = {0, 0};
    const auto& size_m = session.instance.scenario.stage_bounds_m;
    if (type != XR_REFERENCE_SPACE_TYPE_STAGE || size_m[0] <= 0 || size_m[1] <= 0)
        return XR_SPACE_BOUNDS_UNAVAILABLE;
    *bounds = {static_cast<float>(size_m[0]), static_cast<float>(size_m[1])};
    return XR_SUCCESS;
}

XrResult getStationaryReferenceSpaceGenerationId(Call& call, XrSession handle,
                                                 const XrStationaryReferenceSpaceGenerationIdGetInfoEXT* info,
                                                 XrStationaryReferenceSpaceGenerationIdResultEXT* result) {
    const Session& session = call.live<Session>(handle);
    if (info != nullptr) requireStruct(info, XR_TYPE_STATIONARY_REFERENCE_SPACE_GENERATION_ID_GET_INFO_EXT);
    requireStruct(result, XR_TYPE_STATIONARY_REFERENCE_SPACE_GENERATION_ID_RESULT_EXT);
    require(offersReferenceSpace(session.instance, XR_REFERENCE_SPACE_TYPE_STATIONARY_EXT),
            XR_ERROR_REFERENCE_SPACE_UNSUPPORTED, "the scenario offers no stationary space");
    // The id is the same in every run and changes only with the generation.
    constexpr std::uint8_t kFirst[16] = {0x5a, 0x17, 0x10, 0x4a, 0x72, 0x79, 0x40, 0x00,
                                         0x80, 0x00, 0x6d, 0x6f, 0x63, 0x6b, 0x00, 0x00};
    std::copy(std::begin(kFirst), std::end(kFirst), result->generationId.data);
    result->generationId.data[15] = session.instance.conditions.generation;
    return XR_SUCCESS;
}

XrResult createActionSpace(Call& call, XrSession handle, const XrActionSpaceCreateInfo* info, XrSpace* out) {
    Session& session = call.live<Session>(handle);
    requireStruct(info, XR_TYPE_ACTION_SPACE_CREATE_INFO);
    requireValid(out != nullptr, "space is null");
    const Action& action = call.live<Action>(info->action);
    requireValid(&action.set.instance == &session.instance, "the action is of another instance");
    require(action.action_type == XR_ACTION_TYPE_POSE_INPUT, XR_ERROR_ACTION_TYPE_MISMATCH,
            "only a pose action has a space");
    requireSubaction(session.instance, action, info->subactionPath);
    require(isValid(info->poseInActionSpace), XR_ERROR_POSE_INVALID, "poseInActionSpace is not a pose");
    auto space = std::make_unique<Space>(session);
    space->action = action.handle;
    space->subaction_path = info->subactionPath;
    space->origin_from_space = fromXr(info->poseInActionSpace);
    *out = toHandle<XrSpace>(call.create(std::move(space), &session));
    return XR_SUCCESS;
}

XrResult locateSpace(Call& call, XrSpace space_handle, XrSpace base_handle, XrTime time,
                     XrSpaceLocation* location) {
    const Space& space = call.live<Space>(space_handle);
    const Space& base = call.live<Space>(base_handle);
    requireStruct(location, XR_TYPE_SPACE_LOCATION);
    requireTime(time);
    requireValid(&space.session == &base.session, "the spaces are of different sessions");
    auto* velocity = findOutput<XrSpaceVelocity>(location->next, XR_TYPE_SPACE_VELOCITY);
    const std::optional<Pose> base_from_space = baseFromSpace(base, space, time);
    location->locationFlags = base_from_space ? kLocated : 0;
    location->pose = toXr(base_from_space.value_or(Pose{}));
    if (velocity == nullptr) return XR_SUCCESS;
    const std::optional<Velocity> motion = velocityInBase(base, space, time);
    velocity->velocityFlags = motion ? kMoving : 0;
    velocity->linearVelocity = toXr(motion ? motion->linear_m_per_s : Vec3{});
    velocity->angularVelocity = toXr(motion ? motion->angular_rad_per_s : Vec3{});
    return XR_SUCCESS;
}

XrResult locateViews(Call& call, XrSession handle, const XrViewLocateInfo* info, XrViewState* state,
                     std::uint32_t capacity, std::uint32_t* count, XrView* views) {
    const Session& session = call.live<Session>(handle);
    requireStruct(info, XR_TYPE_VIEW_LOCATE_INFO);
    requireStruct(state, XR_TYPE_VIEW_STATE);
    requireViewConfiguration(info->viewConfigurationType);
    requireValid(session.run > 0, "xrBeginSession was not given this view configuration");
    requireTime(info->displayTime);
    const Space& base = call.live<Space>(info->space);
    requireValid(&base.session == &session, "the space is of another session");
    std::optional<Pose> stage_from_base = stageFromSpace(base, info->displayTime);
    if (!session.instance.conditions.head_tracked) stage_from_base.reset();
    state->viewStateFlags =
        stage_from_base ? XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT |
                              XR_VIEW_STATE_ORIENTATION_TRACKED_BIT | XR_VIEW_STATE_POSITION_TRACKED_BIT
                        : XrViewStateFlags{0};
    const std::array<Pose, 2> stage_from_eyes = stageFromEyes(session.instance, info->displayTime);
    constexpr std::array<std::size_t, 2> kEyes{0, 1};
    checkElements(capacity, views, kEyes.size(), XR_TYPE_VIEW);
    return twoCall(capacity, count, views, kEyes, [&](std::size_t eye, XrView& view) {
        view.pose = toXr(stage_from_base ? inverse(*stage_from_base) * stage_from_eyes[eye] : Pose{});
        view.fov = session.instance.scenario.eye_fov[eye];
    });
}

}  // namespace xrmock
