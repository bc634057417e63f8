"""A minimal OpenXR application: an instance, the Vulkan device chosen by the runtime, and a session whose frames are
filled rectangles. It follows the specification and records what the runtime reports."""

from ctypes import c_char_p, c_int32, c_uint32, c_void_p

import vulkan
from openxr import *
from structures import address, array

IDENTITY = Posef(Quaternionf(0, 0, 0, 1), Vector3f(0, 0, 0))

EVENTS = {kind.tag: kind for kind in (
    EventDataInstanceLossPending, EventDataSessionStateChanged, EventDataReferenceSpaceChangePending,
    EventDataEventsLost, EventDataInteractionProfileChanged)}


class Client:
    """Instance, system and Vulkan device."""

    QUEUE_FAMILY = 0

    def __init__(self, name="python client", extensions=("XR_KHR_vulkan_enable2",)):
        self.xr = Functions()
        application = ApplicationInfo(applicationName=name.encode(), apiVersion=API_VERSION_1_0)
        info = InstanceCreateInfo(applicationInfo=application, enabledExtensionCount=len(extensions),
                                  enabledExtensionNames=array(c_char_p, (each.encode() for each in extensions)))
        self.instance = Instance()
        self.xr.xrCreateInstance(info, self.instance)
        self.xr.instance = self.instance
        self.system = SystemId()
        self.xr.xrGetSystem(self.instance, SystemGetInfo(formFactor=FORM_FACTOR_HEAD_MOUNTED_DISPLAY), self.system)
        self.painter = None

    def start_vulkan(self):
        xr, outcome = self.xr, c_int32(-1)
        self.requirements = GraphicsRequirementsVulkan()
        xr.xrGetVulkanGraphicsRequirements2KHR(self.instance, self.system, self.requirements)
        self.vk_instance, self.vk_physical_device, self.vk_device = c_void_p(), c_void_p(), c_void_p()
        xr.xrCreateVulkanInstanceKHR(self.instance, VulkanInstanceCreateInfo(
            systemId=self.system, pfnGetInstanceProcAddr=vulkan.getInstanceProcAddr,
            vulkanCreateInfo=address(vulkan.instance_info(b"python client"))), self.vk_instance, outcome)
        assert outcome.value == 0
        xr.xrGetVulkanGraphicsDevice2KHR(self.instance, VulkanGraphicsDeviceGetInfo(
            systemId=self.system, vulkanInstance=self.vk_instance), self.vk_physical_device)
        xr.xrCreateVulkanDeviceKHR(self.instance, VulkanDeviceCreateInfo(
            systemId=self.system, pfnGetInstanceProcAddr=vulkan.getInstanceProcAddr,
            vulkanPhysicalDevice=self.vk_physical_device,
            vulkanCreateInfo=address(vulkan.device_info(self.QUEUE_FAMILY))), self.vk_device, outcome)
        assert outcome.value == 0
        self.painter = vulkan.Painter(self.vk_device, self.QUEUE_FAMILY)

    def graphics_binding(self):
        return GraphicsBindingVulkan(instance=self.vk_instance, physicalDevice=self.vk_physical_device,
                                     device=self.vk_device, queueFamilyIndex=self.QUEUE_FAMILY, queueIndex=0)

    def events(self):
        """Yields the events since the last call, each as a structure of its own type."""
        while True:
            buffer = EventDataBuffer()
            if self.xr.xrPollEvent(self.instance, buffer) == Result.EVENT_UNAVAILABLE:
                return
            kind = EVENTS[buffer.type]
            yield kind.from_buffer_copy(buffer)

    def path(self, text):
        path = Path()
        self.xr.xrStringToPath(self.instance, text.encode(), path)
        return path

    def close(self):
        """Can be called more than once."""
        if self.instance:
            self.xr.xrDestroyInstance(self.instance)
            self.instance = Instance()
        if self.painter:
            self.painter.close()
            vulkan.destroyInstance(self.vk_instance, None)
            self.painter = None


class SwapchainImages:
    """A colour swapchain and its images."""

    def __init__(self, client, session, width, height, layers):
        self.client, self.width, self.height, self.layers = client, width, height, layers
        self.handle = Swapchain()
        client.xr.xrCreateSwapchain(session, SwapchainCreateInfo(
            usageFlags=SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | SWAPCHAIN_USAGE_TRANSFER_DST_BIT,
            format=vulkan.FORMAT_R8G8B8A8_SRGB, sampleCount=1, width=width, height=height, faceCount=1,
            arraySize=layers, mipCount=1), self.handle)
        self.images = [each.image for each in enumerate_all(
            client.xr.xrEnumerateSwapchainImages, self.handle, kind=SwapchainImageVulkan)]

    def fill(self, colour):
        """Acquires an image, fills it and releases it to the runtime. Returns its index."""
        xr, index = self.client.xr, c_uint32()
        xr.xrAcquireSwapchainImage(self.handle, SwapchainImageAcquireInfo(), index)
        xr.xrWaitSwapchainImage(self.handle, SwapchainImageWaitInfo(timeout=INFINITE_DURATION))
        self.client.painter.fill(self.images[index.value], self.layers, colour)
        xr.xrReleaseSwapchainImage(self.handle, SwapchainImageReleaseInfo())
        return index.value

    def sub_image(self, layer=0):
        return SwapchainSubImage(self.handle, Rect2Di(0, 0, self.width, self.height), layer)


class RunningSession:
    """A session, its reference spaces and swapchains, and one frame at a time."""

    def __init__(self, client):
        self.client, self.xr = client, client.xr
        self.handle = Session()
        self.xr.xrCreateSession(client.instance, SessionCreateInfo(
            next=address(client.graphics_binding()), systemId=client.system), self.handle)
        self.spaces = {kind: self.reference_space(kind) for kind in ReferenceSpaceType}
        view = enumerate_all(self.xr.xrEnumerateViewConfigurationViews, client.instance, client.system,
                             VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, kind=ViewConfigurationView)[0]
        self.world = SwapchainImages(client, self.handle, view.recommendedImageRectWidth,
                                     view.recommendedImageRectHeight, layers=2)
        self.board = SwapchainImages(client, self.handle, 64, 32, layers=1)

    def reference_space(self, kind):
        space = Space()
        self.xr.xrCreateReferenceSpace(self.handle, ReferenceSpaceCreateInfo(
            referenceSpaceType=kind, poseInReferenceSpace=IDENTITY), space)
        return space

    def begin(self):
        self.xr.xrBeginSession(self.handle, SessionBeginInfo(
            primaryViewConfigurationType=VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO))

    def frame(self):
        """Waits for, draws and submits a frame. Returns its FrameState, the view state and the views."""
        state = FrameState()
        self.xr.xrWaitFrame(self.handle, FrameWaitInfo(), state)
        self.xr.xrBeginFrame(self.handle, FrameBeginInfo())
        view_state, views = self.views(state.predictedDisplayTime)
        layers = self.draw(views) if state.shouldRender else []
        self.xr.xrEndFrame(self.handle, FrameEndInfo(
            displayTime=state.predictedDisplayTime, environmentBlendMode=ENVIRONMENT_BLEND_MODE_OPAQUE,
            layerCount=len(layers), layers=array(c_void_p, map(address, layers))))
        return state, view_state, views

    def views(self, time):
        state, count, views = ViewState(), c_uint32(), (View * 2)(View(), View())
        self.xr.xrLocateViews(self.handle, ViewLocateInfo(
            viewConfigurationType=VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, displayTime=time,
            space=self.spaces[ReferenceSpaceType.LOCAL]), state, 2, count, views)
        return state, list(views)[:count.value]

    def draw(self, views):
        """A blue background for both eyes, and a red board half a metre in front of the head."""
        self.world.fill((0.0, 0.2, 0.6, 1.0))
        self.board.fill((0.8, 0.1, 0.1, 1.0))
        projected = [CompositionLayerProjectionView(pose=view.pose, fov=view.fov, subImage=self.world.sub_image(eye))
                     for eye, view in enumerate(views)]
        ahead = Posef(Quaternionf(0, 0, 0, 1), Vector3f(0, 0, -0.5))
        return [CompositionLayerProjection(space=self.spaces[ReferenceSpaceType.LOCAL], viewCount=len(projected),
                                           views=array(CompositionLayerProjectionView, projected)),
                CompositionLayerQuad(space=self.spaces[ReferenceSpaceType.VIEW], eyeVisibility=EYE_VISIBILITY_BOTH,
                                     subImage=self.board.sub_image(), pose=ahead, size=Extent2Df(0.4, 0.2))]

    def locate(self, space, base, time):
        velocity = SpaceVelocity()
        location = SpaceLocation(next=address(velocity))
        self.xr.xrLocateSpace(space, base, time, location)
        return location, velocity
