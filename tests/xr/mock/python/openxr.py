"""The part of OpenXR 1.0 that a Vulkan application needs, through the C ABI and the system's loader.

Written from the specification, using only ctypes. Names are those of the specification, without the Xr prefix:

    instance = Instance()
    xr = Functions()
    xr.xrCreateInstance(InstanceCreateInfo(...), instance)
    xr.instance = instance          # now the functions that need one can be called
    properties = InstanceProperties()
    xr.xrGetInstanceProperties(instance, properties)

A function returns its Result. It raises Failure if the result is an error.
"""

from ctypes import CDLL, CFUNCTYPE, byref, c_char, c_char_p, c_float, c_int32, c_int64, c_uint8, c_uint32
from ctypes import c_uint64, c_void_p
from enum import IntEnum

from structures import P, declare, struct

API_VERSION_1_0 = 1 << 48
NULL_PATH = 0
INFINITE_DURATION = (1 << 63) - 1
MIN_HAPTIC_DURATION = -1


class Result(IntEnum):
    SUCCESS = 0
    TIMEOUT_EXPIRED = 1
    SESSION_LOSS_PENDING = 3
    EVENT_UNAVAILABLE = 4
    SPACE_BOUNDS_UNAVAILABLE = 7
    SESSION_NOT_FOCUSED = 8
    FRAME_DISCARDED = 9
    ERROR_VALIDATION_FAILURE = -1
    ERROR_RUNTIME_FAILURE = -2
    ERROR_OUT_OF_MEMORY = -3
    ERROR_API_VERSION_UNSUPPORTED = -4
    ERROR_INITIALIZATION_FAILED = -6
    ERROR_FUNCTION_UNSUPPORTED = -7
    ERROR_FEATURE_UNSUPPORTED = -8
    ERROR_EXTENSION_NOT_PRESENT = -9
    ERROR_LIMIT_REACHED = -10
    ERROR_SIZE_INSUFFICIENT = -11
    ERROR_HANDLE_INVALID = -12
    ERROR_INSTANCE_LOST = -13
    ERROR_SESSION_RUNNING = -14
    ERROR_SESSION_NOT_RUNNING = -16
    ERROR_SESSION_LOST = -17
    ERROR_SYSTEM_INVALID = -18
    ERROR_PATH_INVALID = -19
    ERROR_PATH_FORMAT_INVALID = -21
    ERROR_PATH_UNSUPPORTED = -22
    ERROR_LAYER_INVALID = -23
    ERROR_ACTION_TYPE_MISMATCH = -27
    ERROR_SESSION_NOT_READY = -28
    ERROR_SESSION_NOT_STOPPING = -29
    ERROR_TIME_INVALID = -30
    ERROR_FORM_FACTOR_UNSUPPORTED = -34
    ERROR_CALL_ORDER_INVALID = -37
    ERROR_GRAPHICS_DEVICE_INVALID = -38
    ERROR_POSE_INVALID = -39
    ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED = -41
    ERROR_NAME_DUPLICATED = -44
    ERROR_ACTIONSET_NOT_ATTACHED = -46
    ERROR_ACTIONSETS_ALREADY_ATTACHED = -47
    ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING = -50
    ERROR_RUNTIME_UNAVAILABLE = -51


class SessionState(IntEnum):
    UNKNOWN = 0
    IDLE = 1
    READY = 2
    SYNCHRONIZED = 3
    VISIBLE = 4
    FOCUSED = 5
    STOPPING = 6
    LOSS_PENDING = 7
    EXITING = 8


class ReferenceSpaceType(IntEnum):
    VIEW = 1
    LOCAL = 2
    STAGE = 3


class ActionType(IntEnum):
    BOOLEAN_INPUT = 1
    FLOAT_INPUT = 2
    VECTOR2F_INPUT = 3
    POSE_INPUT = 4
    VIBRATION_OUTPUT = 100


FORM_FACTOR_HEAD_MOUNTED_DISPLAY = 1
VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO = 2
ENVIRONMENT_BLEND_MODE_OPAQUE = 1
EYE_VISIBILITY_BOTH = 0
LOCATED = 0xF  # position and orientation are valid and tracked; for spaces and views
VELOCITY_VALID = 0x3
SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT = 0x01
SWAPCHAIN_USAGE_TRANSFER_DST_BIT = 0x10
COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT = 0x2


# Handles are pointers on 64-bit machines, atoms have 64 bits. Each has its own type, so that ctypes rejects a session
# where an instance is expected.
class Instance(c_uint64): pass
class Session(c_uint64): pass
class Space(c_uint64): pass
class Swapchain(c_uint64): pass
class ActionSet(c_uint64): pass
class Action(c_uint64): pass
class SystemId(c_uint64): pass
class Path(c_uint64): pass


Bool32 = c_uint32
Time = c_int64

Vector2f = struct(x=c_float, y=c_float)
Vector3f = struct(x=c_float, y=c_float, z=c_float)
Quaternionf = struct(x=c_float, y=c_float, z=c_float, w=c_float)
Posef = struct(orientation=Quaternionf, position=Vector3f)
Fovf = struct(angleLeft=c_float, angleRight=c_float, angleUp=c_float, angleDown=c_float)
Extent2Df = struct(width=c_float, height=c_float)
Rect2Di = struct(x=c_int32, y=c_int32, width=c_int32, height=c_int32)

# Instance and system
ApplicationInfo = struct(applicationName=c_char * 128, applicationVersion=c_uint32, engineName=c_char * 128,
                         engineVersion=c_uint32, apiVersion=c_uint64)
ExtensionProperties = struct(2, extensionName=c_char * 128, extensionVersion=c_uint32)
InstanceCreateInfo = struct(3, createFlags=c_uint64, applicationInfo=ApplicationInfo,
                            enabledApiLayerCount=c_uint32, enabledApiLayerNames=P(c_char_p),
                            enabledExtensionCount=c_uint32, enabledExtensionNames=P(c_char_p))
InstanceProperties = struct(32, runtimeVersion=c_uint64, runtimeName=c_char * 128)
SystemGetInfo = struct(4, formFactor=c_int32)
SystemProperties = struct(5, systemId=SystemId, vendorId=c_uint32, systemName=c_char * 256,
                          maxSwapchainImageHeight=c_uint32, maxSwapchainImageWidth=c_uint32,
                          maxLayerCount=c_uint32, orientationTracking=Bool32, positionTracking=Bool32)
ViewConfigurationProperties = struct(45, viewConfigurationType=c_int32, fovMutable=Bool32)
ViewConfigurationView = struct(41, recommendedImageRectWidth=c_uint32, maxImageRectWidth=c_uint32,
                               recommendedImageRectHeight=c_uint32, maxImageRectHeight=c_uint32,
                               recommendedSwapchainSampleCount=c_uint32, maxSwapchainSampleCount=c_uint32)

# XR_KHR_vulkan_enable2
GraphicsRequirementsVulkan = struct(1000025002, minApiVersionSupported=c_uint64, maxApiVersionSupported=c_uint64)
VulkanInstanceCreateInfo = struct(1000090000, systemId=SystemId, createFlags=c_uint64,
                                  pfnGetInstanceProcAddr=c_void_p, vulkanCreateInfo=c_void_p,
                                  vulkanAllocator=c_void_p)
VulkanDeviceCreateInfo = struct(1000090001, systemId=SystemId, createFlags=c_uint64,
                                pfnGetInstanceProcAddr=c_void_p, vulkanPhysicalDevice=c_void_p,
                                vulkanCreateInfo=c_void_p, vulkanAllocator=c_void_p)
VulkanGraphicsDeviceGetInfo = struct(1000090003, systemId=SystemId, vulkanInstance=c_void_p)
GraphicsBindingVulkan = struct(1000025000, instance=c_void_p, physicalDevice=c_void_p, device=c_void_p,
                               queueFamilyIndex=c_uint32, queueIndex=c_uint32)
SwapchainImageVulkan = struct(1000025001, image=c_uint64)

# Session, events and frames
SessionCreateInfo = struct(8, createFlags=c_uint64, systemId=SystemId)
SessionBeginInfo = struct(10, primaryViewConfigurationType=c_int32)
EventDataBuffer = struct(16, varying=c_uint8 * 4000)
EventDataInstanceLossPending = struct(17, lossTime=Time)
EventDataSessionStateChanged = struct(18, session=Session, state=c_int32, time=Time)
EventDataReferenceSpaceChangePending = struct(40, session=Session, referenceSpaceType=c_int32, changeTime=Time,
                                              poseValid=Bool32, poseInPreviousSpace=Posef)
EventDataEventsLost = struct(49, lostEventCount=c_uint32)
EventDataInteractionProfileChanged = struct(52, session=Session)
FrameWaitInfo = struct(33)
FrameState = struct(44, predictedDisplayTime=Time, predictedDisplayPeriod=c_int64, shouldRender=Bool32)
FrameBeginInfo = struct(46)
FrameEndInfo = struct(12, displayTime=Time, environmentBlendMode=c_int32, layerCount=c_uint32,
                      layers=P(c_void_p))

# Spaces and views
ReferenceSpaceCreateInfo = struct(37, referenceSpaceType=c_int32, poseInReferenceSpace=Posef)
ActionSpaceCreateInfo = struct(38, action=Action, subactionPath=Path, poseInActionSpace=Posef)
SpaceLocation = struct(42, locationFlags=c_uint64, pose=Posef)
SpaceVelocity = struct(43, velocityFlags=c_uint64, linearVelocity=Vector3f, angularVelocity=Vector3f)
ViewLocateInfo = struct(6, viewConfigurationType=c_int32, displayTime=Time, space=Space)
ViewState = struct(11, viewStateFlags=c_uint64)
View = struct(7, pose=Posef, fov=Fovf)

# Swapchains and layers
SwapchainCreateInfo = struct(9, createFlags=c_uint64, usageFlags=c_uint64, format=c_int64, sampleCount=c_uint32,
                             width=c_uint32, height=c_uint32, faceCount=c_uint32, arraySize=c_uint32,
                             mipCount=c_uint32)
SwapchainImageAcquireInfo = struct(55)
SwapchainImageWaitInfo = struct(56, timeout=c_int64)
SwapchainImageReleaseInfo = struct(57)
SwapchainSubImage = struct(swapchain=Swapchain, imageRect=Rect2Di, imageArrayIndex=c_uint32)
CompositionLayerProjectionView = struct(48, pose=Posef, fov=Fovf, subImage=SwapchainSubImage)
CompositionLayerProjection = struct(35, layerFlags=c_uint64, space=Space, viewCount=c_uint32,
                                    views=P(CompositionLayerProjectionView))
CompositionLayerQuad = struct(36, layerFlags=c_uint64, space=Space, eyeVisibility=c_int32,
                              subImage=SwapchainSubImage, pose=Posef, size=Extent2Df)

# Actions
ActionSetCreateInfo = struct(28, actionSetName=c_char * 64, localizedActionSetName=c_char * 128,
                             priority=c_uint32)
ActionCreateInfo = struct(29, actionName=c_char * 64, actionType=c_int32, countSubactionPaths=c_uint32,
                          subactionPaths=P(Path), localizedActionName=c_char * 128)
ActionSuggestedBinding = struct(action=Action, binding=Path)
InteractionProfileSuggestedBinding = struct(51, interactionProfile=Path, countSuggestedBindings=c_uint32,
                                            suggestedBindings=P(ActionSuggestedBinding))
SessionActionSetsAttachInfo = struct(60, countActionSets=c_uint32, actionSets=P(ActionSet))
InteractionProfileState = struct(53, interactionProfile=Path)
ActiveActionSet = struct(actionSet=ActionSet, subactionPath=Path)
ActionsSyncInfo = struct(61, countActiveActionSets=c_uint32, activeActionSets=P(ActiveActionSet))
ActionStateGetInfo = struct(58, action=Action, subactionPath=Path)
ActionStateBoolean = struct(23, currentState=Bool32, changedSinceLastSync=Bool32, lastChangeTime=Time,
                            isActive=Bool32)
ActionStateFloat = struct(24, currentState=c_float, changedSinceLastSync=Bool32, lastChangeTime=Time,
                          isActive=Bool32)
ActionStateVector2f = struct(25, currentState=Vector2f, changedSinceLastSync=Bool32, lastChangeTime=Time,
                             isActive=Bool32)
ActionStatePose = struct(27, isActive=Bool32)
BoundSourcesForActionEnumerateInfo = struct(62, action=Action)
InputSourceLocalizedNameGetInfo = struct(63, sourcePath=Path, whichComponents=c_uint64)
HapticActionInfo = struct(59, action=Action, subactionPath=Path)
HapticVibration = struct(13, duration=c_int64, frequency=c_float, amplitude=c_float)

# Parameters of each function. P(X) accepts an X, an array of X, or None.
SIGNATURES = {
    "xrEnumerateInstanceExtensionProperties": (c_char_p, c_uint32, P(c_uint32), P(ExtensionProperties)),
    "xrCreateInstance": (P(InstanceCreateInfo), P(Instance)),
    "xrDestroyInstance": (Instance,),
    "xrGetInstanceProperties": (Instance, P(InstanceProperties)),
    "xrPollEvent": (Instance, P(EventDataBuffer)),
    "xrResultToString": (Instance, c_int32, P(c_char)),
    "xrStructureTypeToString": (Instance, c_int32, P(c_char)),
    "xrStringToPath": (Instance, c_char_p, P(Path)),
    "xrPathToString": (Instance, Path, c_uint32, P(c_uint32), P(c_char)),
    "xrGetSystem": (Instance, P(SystemGetInfo), P(SystemId)),
    "xrGetSystemProperties": (Instance, SystemId, P(SystemProperties)),
    "xrEnumerateEnvironmentBlendModes": (Instance, SystemId, c_int32, c_uint32, P(c_uint32), P(c_int32)),
    "xrEnumerateViewConfigurations": (Instance, SystemId, c_uint32, P(c_uint32), P(c_int32)),
    "xrGetViewConfigurationProperties": (Instance, SystemId, c_int32, P(ViewConfigurationProperties)),
    "xrEnumerateViewConfigurationViews": (Instance, SystemId, c_int32, c_uint32, P(c_uint32),
                                          P(ViewConfigurationView)),
    "xrGetVulkanGraphicsRequirements2KHR": (Instance, SystemId, P(GraphicsRequirementsVulkan)),
    "xrCreateVulkanInstanceKHR": (Instance, P(VulkanInstanceCreateInfo), P(c_void_p), P(c_int32)),
    "xrGetVulkanGraphicsDevice2KHR": (Instance, P(VulkanGraphicsDeviceGetInfo), P(c_void_p)),
    "xrCreateVulkanDeviceKHR": (Instance, P(VulkanDeviceCreateInfo), P(c_void_p), P(c_int32)),
    "xrCreateSession": (Instance, P(SessionCreateInfo), P(Session)),
    "xrDestroySession": (Session,),
    "xrBeginSession": (Session, P(SessionBeginInfo)),
    "xrEndSession": (Session,),
    "xrRequestExitSession": (Session,),
    "xrEnumerateReferenceSpaces": (Session, c_uint32, P(c_uint32), P(c_int32)),
    "xrCreateReferenceSpace": (Session, P(ReferenceSpaceCreateInfo), P(Space)),
    "xrGetReferenceSpaceBoundsRect": (Session, c_int32, P(Extent2Df)),
    "xrCreateActionSpace": (Session, P(ActionSpaceCreateInfo), P(Space)),
    "xrLocateSpace": (Space, Space, Time, P(SpaceLocation)),
    "xrDestroySpace": (Space,),
    "xrLocateViews": (Session, P(ViewLocateInfo), P(ViewState), c_uint32, P(c_uint32), P(View)),
    "xrEnumerateSwapchainFormats": (Session, c_uint32, P(c_uint32), P(c_int64)),
    "xrCreateSwapchain": (Session, P(SwapchainCreateInfo), P(Swapchain)),
    "xrDestroySwapchain": (Swapchain,),
    "xrEnumerateSwapchainImages": (Swapchain, c_uint32, P(c_uint32), P(SwapchainImageVulkan)),
    "xrAcquireSwapchainImage": (Swapchain, P(SwapchainImageAcquireInfo), P(c_uint32)),
    "xrWaitSwapchainImage": (Swapchain, P(SwapchainImageWaitInfo)),
    "xrReleaseSwapchainImage": (Swapchain, P(SwapchainImageReleaseInfo)),
    "xrWaitFrame": (Session, P(FrameWaitInfo), P(FrameState)),
    "xrBeginFrame": (Session, P(FrameBeginInfo)),
    "xrEndFrame": (Session, P(FrameEndInfo)),
    "xrCreateActionSet": (Instance, P(ActionSetCreateInfo), P(ActionSet)),
    "xrDestroyActionSet": (ActionSet,),
    "xrCreateAction": (ActionSet, P(ActionCreateInfo), P(Action)),
    "xrDestroyAction": (Action,),
    "xrSuggestInteractionProfileBindings": (Instance, P(InteractionProfileSuggestedBinding)),
    "xrAttachSessionActionSets": (Session, P(SessionActionSetsAttachInfo)),
    "xrGetCurrentInteractionProfile": (Session, Path, P(InteractionProfileState)),
    "xrSyncActions": (Session, P(ActionsSyncInfo)),
    "xrGetActionStateBoolean": (Session, P(ActionStateGetInfo), P(ActionStateBoolean)),
    "xrGetActionStateFloat": (Session, P(ActionStateGetInfo), P(ActionStateFloat)),
    "xrGetActionStateVector2f": (Session, P(ActionStateGetInfo), P(ActionStateVector2f)),
    "xrGetActionStatePose": (Session, P(ActionStateGetInfo), P(ActionStatePose)),
    "xrEnumerateBoundSourcesForAction": (Session, P(BoundSourcesForActionEnumerateInfo), c_uint32, P(c_uint32),
                                         P(Path)),
    "xrGetInputSourceLocalizedName": (Session, P(InputSourceLocalizedNameGetInfo), c_uint32, P(c_uint32),
                                      P(c_char)),
    "xrApplyHapticFeedback": (Session, P(HapticActionInfo), P(HapticVibration)),
    "xrStopHapticFeedback": (Session, P(HapticActionInfo)),
}


class Failure(Exception):
    def __init__(self, function, result):
        super().__init__(f"{function}: {result.name}")
        self.result = result


class Functions:
    """The functions by name, looked up on first use through xrGetInstanceProcAddr."""

    def __init__(self):
        self._look_up = declare(CDLL("libopenxr_loader.so.1").xrGetInstanceProcAddr, c_int32,
                                (Instance, c_char_p, P(c_void_p)))
        self.instance = Instance()

    def __getattr__(self, name):
        found = c_void_p()
        result = self._look_up(self.instance, name.encode(), byref(found))
        if result < 0:
            raise Failure(f"xrGetInstanceProcAddr({name})", Result(result))
        function = CFUNCTYPE(c_int32, *SIGNATURES[name])(found.value)

        def call(*arguments):
            outcome = Result(function(*arguments))
            if outcome < 0:
                raise Failure(name, outcome)
            return outcome

        setattr(self, name, call)
        return call

    def forget(self):
        """Call after xrDestroyInstance: the functions found so far belonged to that instance."""
        look_up = self._look_up
        self.__dict__.clear()
        self._look_up, self.instance = look_up, Instance()


def enumerate_all(function, *arguments, kind):
    """The two-call idiom: the values of a function that ends in (capacity, count, values)."""
    count = c_uint32()
    function(*arguments, 0, count, None)
    values = (kind * count.value)(*(kind() for _ in range(count.value)))
    function(*arguments, count.value, count, values)
    return list(values)[:count.value]


def text_of(function, *arguments):
    """The two-call idiom for a string."""
    count = c_uint32()
    function(*arguments, 0, count, None)
    buffer = (c_char * count.value)()
    function(*arguments, count.value, count, buffer)
    return buffer.value.decode()
