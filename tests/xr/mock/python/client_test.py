"""Tests the mock runtime from outside: a client in another language, written from the specification for the C ABI."""

import json
import math
import os
import tempfile
import unittest
from ctypes import c_char, c_uint32

from client import IDENTITY, Client, RunningSession
from openxr import *
from structures import address, array

State = SessionState
IPD_M = 0.07
SCENARIO = {
    "version": 1,
    "refresh_hz": 100,
    "eyes": {"ipd_m": IPD_M, "recommended_size": [96, 80]},
    "head": [{"t_s": 0, "position": [0, 1.5, 0]}, {"t_s": 10, "position": [0, 1.5, -1]}],
    "controllers": {
        "profile": "/interaction_profiles/khr/simple_controller",
        "left": {"poses": [{"t_s": 0, "position": [-0.2, 1.2, -0.3]}],
                 "values": [{"t_s": 1.1, "select/click": True}, {"t_s": 1.2, "select/click": False}]},
        "right": {"poses": [{"t_s": 0, "position": [0.2, 1.2, -0.3]}]}},
}


class Actions:
    """One action of each kind that the simple controller supports, bound for both hands."""

    def __init__(self, client):
        self.client, self.xr = client, client.xr
        self.set = ActionSet()
        self.xr.xrCreateActionSet(client.instance, ActionSetCreateInfo(
            actionSetName=b"hands", localizedActionSetName=b"Hands"), self.set)
        self.hands = {side: client.path(f"/user/hand/{side}") for side in ("left", "right")}
        self.select = self._action(b"select", ActionType.BOOLEAN_INPUT)
        self.aim = self._action(b"aim", ActionType.POSE_INPUT)
        self.buzz = self._action(b"buzz", ActionType.VIBRATION_OUTPUT)
        bindings = [ActionSuggestedBinding(action, client.path(f"/user/hand/{side}{component}"))
                    for side in self.hands
                    for action, component in ((self.select, "/input/select/click"), (self.aim, "/input/aim/pose"),
                                              (self.buzz, "/output/haptic"))]
        self.profile = client.path("/interaction_profiles/khr/simple_controller")
        self.xr.xrSuggestInteractionProfileBindings(client.instance, InteractionProfileSuggestedBinding(
            interactionProfile=self.profile, countSuggestedBindings=len(bindings),
            suggestedBindings=array(ActionSuggestedBinding, bindings)))

    def _action(self, name, kind):
        action = Action()
        self.xr.xrCreateAction(self.set, ActionCreateInfo(
            actionName=name, actionType=kind, countSubactionPaths=2, subactionPaths=array(Path, self.hands.values()),
            localizedActionName=name.title()), action)
        return action

    def attach(self, session):
        self.xr.xrAttachSessionActionSets(session, SessionActionSetsAttachInfo(
            countActionSets=1, actionSets=array(ActionSet, [self.set])))

    def sync(self, session):
        return self.xr.xrSyncActions(session, ActionsSyncInfo(
            countActiveActionSets=1, activeActionSets=array(ActiveActionSet, [ActiveActionSet(self.set, Path())])))

    def selected(self, session, side):
        state = ActionStateBoolean()
        self.xr.xrGetActionStateBoolean(session, ActionStateGetInfo(action=self.select,
                                                                    subactionPath=self.hands[side]), state)
        return state

    def aim_space(self, session, side):
        space = Space()
        self.xr.xrCreateActionSpace(session, ActionSpaceCreateInfo(
            action=self.aim, subactionPath=self.hands[side], poseInActionSpace=IDENTITY), space)
        return space


class MockRuntimeTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        os.environ["XRMOCK_CLOCK"] = "virtual"
        self.play(SCENARIO)

    def play(self, scenario):
        path = os.path.join(self.folder, "scenario.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(scenario, file)
        os.environ["XRMOCK_SCENARIO"] = path

    def start(self):
        client = Client()
        self.addCleanup(client.close)
        client.start_vulkan()
        return client

    def refused(self, result, function, *arguments):
        with self.assertRaises(Failure) as caught:
            function(*arguments)
        self.assertEqual(caught.exception.result, result, str(caught.exception))

    def states(self, client, session):
        """Returns the reported session states. There must be no other events."""
        states = []
        for event in client.events():
            self.assertIsInstance(event, EventDataSessionStateChanged)
            self.assertEqual(event.session.value, session.handle.value)
            self.assertGreater(event.time, 0)
            states.append(State(event.state))
        return states


class InstanceTest(MockRuntimeTest):
    def test_offers_what_it_says(self):
        client = self.start()
        xr = client.xr
        self.assertEqual(xr.xrResultToString(client.instance, -28, (text := (c_char * 64)())), Result.SUCCESS)
        self.assertEqual(text.value, b"XR_ERROR_SESSION_NOT_READY")
        xr.xrStructureTypeToString(client.instance, View.tag, text)
        self.assertEqual(text.value, b"XR_TYPE_VIEW")
        properties = InstanceProperties()
        xr.xrGetInstanceProperties(client.instance, properties)
        self.assertTrue(properties.runtimeName)
        system = SystemProperties()
        xr.xrGetSystemProperties(client.instance, client.system, system)
        self.assertEqual(system.systemId.value, client.system.value)
        self.assertGreaterEqual(system.maxLayerCount, 16)
        self.assertTrue(system.orientationTracking and system.positionTracking)
        self.assertLessEqual(client.requirements.minApiVersionSupported, client.requirements.maxApiVersionSupported)

        stereo = VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO
        self.assertIn(stereo, enumerate_all(xr.xrEnumerateViewConfigurations, client.instance, client.system,
                                            kind=c_int32))
        self.assertIn(ENVIRONMENT_BLEND_MODE_OPAQUE, enumerate_all(
            xr.xrEnumerateEnvironmentBlendModes, client.instance, client.system, stereo, kind=c_int32))
        configuration = ViewConfigurationProperties()
        xr.xrGetViewConfigurationProperties(client.instance, client.system, stereo, configuration)
        self.assertEqual(configuration.viewConfigurationType, stereo)
        views = enumerate_all(xr.xrEnumerateViewConfigurationViews, client.instance, client.system, stereo,
                              kind=ViewConfigurationView)
        self.assertEqual(len(views), 2)
        for view in views:
            self.assertEqual((view.recommendedImageRectWidth, view.recommendedImageRectHeight), (96, 80))
            self.assertLessEqual(view.recommendedImageRectWidth, view.maxImageRectWidth)
            self.assertLessEqual(view.recommendedSwapchainSampleCount, view.maxSwapchainSampleCount)

    def test_paths_are_atoms(self):
        client = Client()
        self.addCleanup(client.close)
        one, same, other = (client.path(text) for text in ("/a/b", "/a/b", "/a/c"))
        self.assertEqual(one.value, same.value)
        self.assertNotEqual(one.value, other.value)
        self.assertEqual(text_of(client.xr.xrPathToString, client.instance, other), "/a/c")
        for bad in ("", "a", "/", "/A", "/a/", "/a//b", "/a/..", "/a b"):
            self.refused(Result.ERROR_PATH_FORMAT_INVALID, client.path, bad)
        count, short = c_uint32(), (c_char * 3)()
        self.refused(Result.ERROR_SIZE_INSUFFICIENT, client.xr.xrPathToString, client.instance, one, 3, count, short)
        self.assertEqual(count.value, 5)

    def test_refuses_a_newer_api_and_unknown_extensions(self):
        xr, instance = Functions(), Instance()
        newer = ApplicationInfo(applicationName=b"newer", apiVersion=1 << 48 | 1 << 32)
        self.refused(Result.ERROR_API_VERSION_UNSUPPORTED, xr.xrCreateInstance,
                     InstanceCreateInfo(applicationInfo=newer), instance)
        with self.assertRaises(Failure) as caught:
            Client(extensions=("XR_NOBODY_has_this",))
        self.assertEqual(caught.exception.result, Result.ERROR_EXTENSION_NOT_PRESENT)


class SessionTest(MockRuntimeTest):
    def test_two_whole_lives_in_one_instance(self):
        client = self.start()
        actions = Actions(client)
        end = self.live(client, actions, first_frame_after=0)
        self.live(client, actions, first_frame_after=end)

    def live(self, client, actions, first_frame_after):
        """Runs a session through all its states. Returns the display time of the last frame."""
        xr = client.xr
        session = RunningSession(client)
        self.assertEqual(self.states(client, session), [State.IDLE, State.READY])
        self.check_reference_spaces(session)
        self.refused(Result.ERROR_SESSION_NOT_RUNNING, session.frame)
        self.refused(Result.ERROR_SESSION_NOT_RUNNING, xr.xrEndSession, session.handle)
        self.refused(Result.ERROR_SESSION_NOT_RUNNING, xr.xrRequestExitSession, session.handle)
        actions.attach(session.handle)
        self.refused(Result.ERROR_ACTIONSETS_ALREADY_ATTACHED, actions.attach, session.handle)

        session.begin()
        self.refused(Result.ERROR_SESSION_RUNNING, session.begin)
        self.last_time, self.period = first_frame_after, None
        for state, rendered in ((State.SYNCHRONIZED, False), (State.VISIBLE, False), (State.FOCUSED, True)):
            self.assertEqual(actions.sync(session.handle), Result.SESSION_NOT_FOCUSED)
            self.assertFalse(actions.selected(session.handle, "left").isActive)
            self.assertEqual(self.check_frame(session), rendered)
            self.assertEqual(self.states(client, session), [state])
        self.use_actions(client, session, actions)

        self.refused(Result.ERROR_SESSION_NOT_STOPPING, xr.xrEndSession, session.handle)
        xr.xrRequestExitSession(session.handle)
        on_the_way = []
        while State.STOPPING not in on_the_way:
            on_the_way += self.states(client, session)
            if State.STOPPING not in on_the_way:
                self.check_frame(session)
        self.assertEqual(on_the_way, [State.VISIBLE, State.SYNCHRONIZED, State.STOPPING])
        xr.xrEndSession(session.handle)
        self.assertEqual(self.states(client, session), [State.IDLE, State.EXITING])
        self.refused(Result.ERROR_SESSION_NOT_READY, session.begin)
        xr.xrDestroySession(session.handle)
        for handle, destroy in ((session.handle, xr.xrDestroySession),
                                (session.spaces[ReferenceSpaceType.VIEW], xr.xrDestroySpace),
                                (session.world.handle, xr.xrDestroySwapchain)):
            self.refused(Result.ERROR_HANDLE_INVALID, destroy, handle)
        return self.last_time

    def check_reference_spaces(self, session):
        offered = enumerate_all(session.xr.xrEnumerateReferenceSpaces, session.handle, kind=c_int32)
        self.assertEqual(len(set(offered)), len(offered))
        self.assertLessEqual(set(ReferenceSpaceType), set(offered))
        self.assertIn(43, enumerate_all(session.xr.xrEnumerateSwapchainFormats, session.handle, kind=c_int64))
        bounds = Extent2Df(-1, -1)
        self.assertEqual(session.xr.xrGetReferenceSpaceBoundsRect(session.handle, ReferenceSpaceType.STAGE, bounds),
                         Result.SUCCESS)
        self.assertTrue(bounds.width > 0 and bounds.height > 0)
        self.assertEqual(session.xr.xrGetReferenceSpaceBoundsRect(session.handle, ReferenceSpaceType.VIEW, bounds),
                         Result.SPACE_BOUNDS_UNAVAILABLE)
        self.assertEqual((bounds.width, bounds.height), (0, 0))

    def check_frame(self, session):
        """Runs a frame. Returns whether it should be rendered."""
        state, view_state, views = session.frame()
        self.assertGreater(state.predictedDisplayTime, self.last_time)
        self.assertEqual(state.predictedDisplayPeriod, 10_000_000)
        if self.period:
            self.assertEqual((state.predictedDisplayTime - self.last_time) % state.predictedDisplayPeriod, 0)
        self.last_time, self.period = state.predictedDisplayTime, state.predictedDisplayPeriod
        self.check_views(view_state, views)
        self.check_head(session)
        return bool(state.shouldRender)

    def check_views(self, view_state, views):
        self.assertEqual(view_state.viewStateFlags, LOCATED)
        self.assertEqual(len(views), 2)
        for view in views:
            self.assertLess(view.fov.angleLeft, view.fov.angleRight)
            self.assertLess(view.fov.angleDown, view.fov.angleUp)
            q = view.pose.orientation
            self.assertAlmostEqual(q.x**2 + q.y**2 + q.z**2 + q.w**2, 1, places=5)
        left, right = (view.pose.position for view in views)
        self.assertAlmostEqual(math.dist((left.x, left.y, left.z), (right.x, right.y, right.z)), IPD_M, places=5)
        self.assertLess(left.x, right.x)

    def check_head(self, session):
        """The head moves forward at 0.1 m/s. LOCAL has the height at which the head started."""
        location, velocity = session.locate(session.spaces[ReferenceSpaceType.VIEW],
                                            session.spaces[ReferenceSpaceType.STAGE], self.last_time)
        self.assertEqual(location.locationFlags, LOCATED)
        self.assertAlmostEqual(location.pose.position.y, 1.5, places=5)
        self.assertAlmostEqual(location.pose.position.z, -self.last_time * 1e-10, places=4)
        self.assertEqual(velocity.velocityFlags, VELOCITY_VALID)
        self.assertAlmostEqual(velocity.linearVelocity.z, -0.1, places=4)
        same, _ = session.locate(session.spaces[ReferenceSpaceType.VIEW], session.spaces[ReferenceSpaceType.VIEW],
                                 self.last_time)
        self.assertEqual((same.pose.position.x, same.pose.orientation.w), (0, 1))

    def use_actions(self, client, session, actions):
        """The scripted click arrives as one press and one release. The aim pose is as scripted."""
        xr, handle = client.xr, session.handle
        self.assertEqual(actions.sync(handle), Result.SUCCESS)
        self.assertEqual([type(event) for event in client.events()], [EventDataInteractionProfileChanged])
        for hand in actions.hands.values():
            current = InteractionProfileState()
            xr.xrGetCurrentInteractionProfile(handle, hand, current)
            self.assertEqual(current.interactionProfile.value, actions.profile.value)
        pressed, changes = 0, []
        for _ in range(30):
            self.assertEqual(actions.sync(handle), Result.SUCCESS)
            left, right = actions.selected(handle, "left"), actions.selected(handle, "right")
            self.assertTrue(left.isActive and right.isActive)
            self.assertFalse(right.currentState or right.changedSinceLastSync)
            if left.changedSinceLastSync:
                changes.append((left.lastChangeTime, left.currentState))
            pressed += left.currentState
            self.check_frame(session)
        self.assertEqual(self.states(client, session), [])
        if changes:  # only the first session is running at the time of the click
            self.assertEqual([value for _, value in changes], [1, 0])
            self.assertLess(changes[0][0], changes[1][0])
            self.assertAlmostEqual(pressed, 10, delta=1)
        sources = enumerate_all(xr.xrEnumerateBoundSourcesForAction, handle,
                                BoundSourcesForActionEnumerateInfo(action=actions.select), kind=Path)
        self.assertEqual(len(sources), 2)
        for source in sources:
            self.assertTrue(text_of(xr.xrGetInputSourceLocalizedName, handle,
                                    InputSourceLocalizedNameGetInfo(sourcePath=source, whichComponents=7)))
        location, _ = session.locate(actions.aim_space(handle, "left"),
                                     session.spaces[ReferenceSpaceType.STAGE], self.last_time)
        self.assertEqual(location.locationFlags, LOCATED)
        self.assertAlmostEqual(location.pose.position.x, -0.2, places=5)
        buzz = HapticActionInfo(action=actions.buzz, subactionPath=actions.hands["right"])
        self.assertEqual(xr.xrApplyHapticFeedback(handle, buzz, HapticVibration(
            duration=MIN_HAPTIC_DURATION, amplitude=0.5)), Result.SUCCESS)
        self.assertEqual(xr.xrStopHapticFeedback(handle, buzz), Result.SUCCESS)

class LossTest(MockRuntimeTest):
    def focus(self, client):
        session = RunningSession(client)
        session.begin()
        for _ in range(3):
            session.frame()
        self.assertEqual(self.states(client, session)[-1], State.FOCUSED)
        return session

    def test_a_session_is_lost_and_another_made(self):
        self.play(SCENARIO | {"version": 2, "events": [{"frame": 4, "session_loss": {"lost_after_s": 0.05}}]})
        client = self.start()
        session = self.focus(client)
        pending = 0
        with self.assertRaises(Failure) as caught:
            for _ in range(20):
                session.frame()
                if State.LOSS_PENDING in self.states(client, session):
                    self.assertEqual(client.xr.xrEnumerateReferenceSpaces(session.handle, 0, c_uint32(), None),
                                     Result.SESSION_LOSS_PENDING)
                    pending += 1
        self.assertEqual(caught.exception.result, Result.ERROR_SESSION_LOST)
        self.assertEqual(pending, 1)
        self.refused(Result.ERROR_SESSION_LOST, session.frame)
        client.xr.xrDestroySession(session.handle)
        self.refused(Result.ERROR_HANDLE_INVALID, session.frame)
        self.focus(client).frame()

    def test_the_instance_is_lost_and_another_made(self):
        self.play(SCENARIO | {"version": 2, "events": [{"frame": 4, "instance_loss": {"lost_after_s": 0.05}}]})
        client = self.start()
        session = self.focus(client)
        announced, last_time = [], 0
        with self.assertRaises(Failure) as caught:
            for _ in range(20):
                last_time = session.frame()[0].predictedDisplayTime
                announced += [event for event in client.events() if isinstance(event, EventDataInstanceLossPending)]
        self.assertEqual(caught.exception.result, Result.ERROR_INSTANCE_LOST)
        self.assertEqual(len(announced), 1)
        self.assertAlmostEqual(announced[0].lossTime, last_time, delta=2e7)
        self.refused(Result.ERROR_INSTANCE_LOST, session.frame)
        self.refused(Result.ERROR_INSTANCE_LOST, client.path, "/a")
        client.xr.xrDestroySession(session.handle)
        client.close()
        self.play(SCENARIO)
        self.focus(self.start()).frame()


if __name__ == "__main__":
    unittest.main()
