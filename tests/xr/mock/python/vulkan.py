"""The part of Vulkan needed to clear a swapchain image, through the C ABI and the system's loader."""

from ctypes import CDLL, c_char_p, c_float, c_int32, c_uint32, c_uint64, c_void_p, cast

from structures import P, address, array, declare, struct

API_VERSION_1_0 = 1 << 22
FORMAT_R8G8B8A8_SRGB = 43
IMAGE_ASPECT_COLOR_BIT = 1
LAYOUT_TRANSFER_DST_OPTIMAL = 7
LAYOUT_COLOR_ATTACHMENT_OPTIMAL = 2
ACCESS_COLOR_ATTACHMENT_WRITE_BIT = 0x100
ACCESS_TRANSFER_WRITE_BIT = 0x1000
STAGE_COLOR_ATTACHMENT_OUTPUT_BIT = 0x400
STAGE_TRANSFER_BIT = 0x1000
QUEUE_FAMILY_IGNORED = 0xFFFFFFFF
NO_TIMEOUT = (1 << 64) - 1

ApplicationInfo = struct(0, pApplicationName=c_char_p, applicationVersion=c_uint32, pEngineName=c_char_p,
                         engineVersion=c_uint32, apiVersion=c_uint32)
InstanceCreateInfo = struct(1, flags=c_uint32, pApplicationInfo=P(ApplicationInfo), enabledLayerCount=c_uint32,
                            ppEnabledLayerNames=P(c_char_p), enabledExtensionCount=c_uint32,
                            ppEnabledExtensionNames=P(c_char_p))
DeviceQueueCreateInfo = struct(2, flags=c_uint32, queueFamilyIndex=c_uint32, queueCount=c_uint32,
                               pQueuePriorities=P(c_float))
DeviceCreateInfo = struct(3, flags=c_uint32, queueCreateInfoCount=c_uint32,
                          pQueueCreateInfos=P(DeviceQueueCreateInfo), enabledLayerCount=c_uint32,
                          ppEnabledLayerNames=P(c_char_p), enabledExtensionCount=c_uint32,
                          ppEnabledExtensionNames=P(c_char_p), pEnabledFeatures=c_void_p)
SubmitInfo = struct(4, waitSemaphoreCount=c_uint32, pWaitSemaphores=c_void_p, pWaitDstStageMask=c_void_p,
                    commandBufferCount=c_uint32, pCommandBuffers=P(c_void_p), signalSemaphoreCount=c_uint32,
                    pSignalSemaphores=c_void_p)
FenceCreateInfo = struct(8, flags=c_uint32)
CommandPoolCreateInfo = struct(39, flags=c_uint32, queueFamilyIndex=c_uint32)
CommandBufferAllocateInfo = struct(40, commandPool=c_uint64, level=c_int32, commandBufferCount=c_uint32)
CommandBufferBeginInfo = struct(42, flags=c_uint32, pInheritanceInfo=c_void_p)
ImageSubresourceRange = struct(aspectMask=c_uint32, baseMipLevel=c_uint32, levelCount=c_uint32,
                               baseArrayLayer=c_uint32, layerCount=c_uint32)
ImageMemoryBarrier = struct(45, srcAccessMask=c_uint32, dstAccessMask=c_uint32, oldLayout=c_int32,
                            newLayout=c_int32, srcQueueFamilyIndex=c_uint32, dstQueueFamilyIndex=c_uint32,
                            image=c_uint64, subresourceRange=ImageSubresourceRange)

_library = CDLL("libvulkan.so.1")
getInstanceProcAddr = cast(_library.vkGetInstanceProcAddr, c_void_p)


def _function(name, *arguments):
    """Wraps a function so that it raises if its VkResult is an error."""
    function = declare(_library[name], c_int32, arguments)

    def call(*values):
        if function(*values) < 0:
            raise RuntimeError(f"{name} failed")

    return call


_getDeviceQueue = declare(_library.vkGetDeviceQueue, None, (c_void_p, c_uint32, c_uint32, P(c_void_p)))
_createCommandPool = _function("vkCreateCommandPool", c_void_p, P(CommandPoolCreateInfo), c_void_p, P(c_uint64))
_allocateCommandBuffers = _function("vkAllocateCommandBuffers", c_void_p, P(CommandBufferAllocateInfo),
                                    P(c_void_p))
_beginCommandBuffer = _function("vkBeginCommandBuffer", c_void_p, P(CommandBufferBeginInfo))
_endCommandBuffer = _function("vkEndCommandBuffer", c_void_p)
_createFence = _function("vkCreateFence", c_void_p, P(FenceCreateInfo), c_void_p, P(c_uint64))
_waitForFences = _function("vkWaitForFences", c_void_p, c_uint32, P(c_uint64), c_uint32, c_uint64)
_resetFences = _function("vkResetFences", c_void_p, c_uint32, P(c_uint64))
_queueSubmit = _function("vkQueueSubmit", c_void_p, c_uint32, P(SubmitInfo), c_uint64)
_deviceWaitIdle = _function("vkDeviceWaitIdle", c_void_p)
_pipelineBarrier = declare(_library.vkCmdPipelineBarrier, None, (
    c_void_p, c_uint32, c_uint32, c_uint32, c_uint32, c_void_p, c_uint32, c_void_p, c_uint32,
    P(ImageMemoryBarrier)))
_clearColorImage = declare(_library.vkCmdClearColorImage, None, (
    c_void_p, c_uint64, c_int32, P(c_float * 4), c_uint32, P(ImageSubresourceRange)))
_destroyFence = declare(_library.vkDestroyFence, None, (c_void_p, c_uint64, c_void_p))
_destroyCommandPool = declare(_library.vkDestroyCommandPool, None, (c_void_p, c_uint64, c_void_p))
_destroyDevice = declare(_library.vkDestroyDevice, None, (c_void_p, c_void_p))
destroyInstance = declare(_library.vkDestroyInstance, None, (c_void_p, c_void_p))


def instance_info(name):
    application = ApplicationInfo(pApplicationName=name, apiVersion=API_VERSION_1_0)
    return InstanceCreateInfo(pApplicationInfo=array(ApplicationInfo, [application]))


def device_info(queue_family):
    queue = DeviceQueueCreateInfo(queueFamilyIndex=queue_family, queueCount=1,
                                  pQueuePriorities=array(c_float, [1.0]))
    return DeviceCreateInfo(queueCreateInfoCount=1, pQueueCreateInfos=array(DeviceQueueCreateInfo, [queue]))


class Painter:
    """Fills images with a colour, one at a time."""

    def __init__(self, device, queue_family):
        self.device = device
        self._queue, self._pool, self._commands, self._fence = c_void_p(), c_uint64(), c_void_p(), c_uint64()
        _getDeviceQueue(device, queue_family, 0, self._queue)
        resettable = 2
        _createCommandPool(device, CommandPoolCreateInfo(flags=resettable, queueFamilyIndex=queue_family), None,
                           self._pool)
        _allocateCommandBuffers(device, CommandBufferAllocateInfo(commandPool=self._pool, commandBufferCount=1),
                                self._commands)
        _createFence(device, FenceCreateInfo(), None, self._fence)

    def fill(self, image, layers, colour):
        """The image is in COLOR_ATTACHMENT_OPTIMAL before and after, the layout that OpenXR runtimes use."""
        commands, whole = self._commands, ImageSubresourceRange(IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, layers)
        _beginCommandBuffer(commands, CommandBufferBeginInfo(flags=1))
        self._barrier(image, whole, LAYOUT_COLOR_ATTACHMENT_OPTIMAL, LAYOUT_TRANSFER_DST_OPTIMAL)
        _clearColorImage(commands, image, LAYOUT_TRANSFER_DST_OPTIMAL, (c_float * 4)(*colour), 1, whole)
        self._barrier(image, whole, LAYOUT_TRANSFER_DST_OPTIMAL, LAYOUT_COLOR_ATTACHMENT_OPTIMAL)
        _endCommandBuffer(commands)
        _queueSubmit(self._queue, 1, SubmitInfo(commandBufferCount=1, pCommandBuffers=array(c_void_p, [commands])),
                     self._fence)
        _waitForFences(self.device, 1, self._fence, 1, NO_TIMEOUT)
        _resetFences(self.device, 1, self._fence)

    def _barrier(self, image, whole, before, after):
        access = {LAYOUT_TRANSFER_DST_OPTIMAL: ACCESS_TRANSFER_WRITE_BIT,
                  LAYOUT_COLOR_ATTACHMENT_OPTIMAL: ACCESS_COLOR_ATTACHMENT_WRITE_BIT}
        stages = STAGE_TRANSFER_BIT | STAGE_COLOR_ATTACHMENT_OUTPUT_BIT
        barrier = ImageMemoryBarrier(srcAccessMask=access[before], dstAccessMask=access[after], oldLayout=before,
                                     newLayout=after, srcQueueFamilyIndex=QUEUE_FAMILY_IGNORED,
                                     dstQueueFamilyIndex=QUEUE_FAMILY_IGNORED, image=image,
                                     subresourceRange=whole)
        _pipelineBarrier(self._commands, stages, stages, 0, 0, None, 0, None, 1, barrier)

    def close(self):
        _deviceWaitIdle(self.device)
        _destroyFence(self.device, self._fence, None)
        _destroyCommandPool(self.device, self._pool, None)
        _destroyDevice(self.device, None)
