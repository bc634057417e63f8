#!/usr/bin/env python3
"""Controls a run of the mock OpenXR runtime through its socket (XRMOCK_CONTROL).

    python3 xrmock.py SOCKET state
    python3 xrmock.py SOCKET recenter --space stage
    python3 xrmock.py SOCKET apply '{"events": [{"refresh_hz": 72}]}'

As a module:

    with xrmock.Client("/tmp/run.sock") as mock:
        mock.pause()
        mock.step(10)
        print(mock.state()["head"])

SCENARIO.md describes requests and scenario fragments. Standard library only.
"""
import argparse
import base64
import json
import socket
import sys
import time


class MockError(Exception):
    """The runtime refused a request: field and reason."""


class Client:
    """A connection. Requests are answered at the application's next calls.

    Waiting for a reply ends with TimeoutError after timeout_s; the connection stays usable.
    """

    def __init__(self, path, timeout_s=10.0, connect_within_s=0.0):
        deadline = time.monotonic() + connect_within_s
        while True:
            self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            self._socket.settimeout(timeout_s)
            try:
                self._socket.connect(path)
                break
            except OSError:
                self._socket.close()
                if time.monotonic() >= deadline:
                    raise
                time.sleep(0.02)
        self._timeout_s = timeout_s
        self._received = b""
        self._last_id = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._socket.close()

    def send(self, **request):
        """Sends a request without waiting; its id."""
        self._last_id += 1
        line = json.dumps({"id": self._last_id, **request}) + "\n"
        self._socket.sendall(line.encode())
        return self._last_id

    def receive(self, request_id, timeout_s=None):
        """The reply to a request. Replies to others that come before it are passed over."""
        deadline = time.monotonic() + (self._timeout_s if timeout_s is None else timeout_s)
        while True:
            reply = json.loads(self._line(deadline))
            if reply.get("id") not in (request_id, None):
                continue
            if not reply.get("ok"):
                raise MockError(reply.get("error", "no reason was given"))
            return reply

    def _line(self, deadline):
        while b"\n" not in self._received:
            self._socket.settimeout(max(deadline - time.monotonic(), 1e-3))
            try:
                received = self._socket.recv(1 << 16)
            finally:
                self._socket.settimeout(self._timeout_s)
            if not received:
                raise ConnectionError("the runtime has gone")
            self._received += received
        line, self._received = self._received.split(b"\n", 1)
        return line

    def request(self, **request):
        return self.receive(self.send(**request))

    def state(self):
        return self.request(get="state")

    def pause(self):
        """Frames wait for step() from now on."""
        return self.request(pause=True)

    def resume(self):
        return self.request(pause=False)

    def step(self, frames=1):
        """Lets so many frames go; returns when the application waits for the next one."""
        return self.request(step=frames)

    def wait(self, timeout_s=None, **condition):
        """wait(frame=300), wait(t_s=2.5), wait(session_state="focused") or wait(haptic_pulses=1)."""
        return self.receive(self.send(wait=condition), timeout_s)

    def picture(self, eye="left"):
        """The bytes of a PNG file of what the eye sees of the next frame."""
        return base64.b64decode(self.request(picture={"eye": eye})["png"])

    def apply(self, fragment):
        """A fragment of a scenario: its times count from now."""
        return self.request(apply=fragment)

    def event(self, **event):
        return self.apply({"events": [event]})

    def head(self, position, orientation=(0, 0, 0, 1)):
        key = {"position": list(position), "orientation": list(orientation)}
        return self.apply({"head": [key]})

    def controller(self, hand, position=None, orientation=(0, 0, 0, 1), **values):
        """controller("left", position=(0, 1, -0.4)), controller("right", trigger_value=0.7, a_click=True)."""
        fragment = {}
        if position is not None:
            fragment["poses"] = [{"position": list(position), "orientation": list(orientation)}]
        if values:
            fragment["values"] = [{"/".join(name.rsplit("_", 1)): value for name, value in values.items()}]
        return self.apply({"controllers": {hand: fragment}})

    def recenter(self, **how):
        """recenter(), recenter(space="stage", pose={"position": [1, 0, 0]}, pose_valid=False, delay_s=0.5)."""
        return self.event(recenter=how)

    def session(self, state):
        """Heads for focused, visible, synchronized, stopped or exiting."""
        return self.event(session=state)

    def user_presence(self, present):
        return self.event(user_presence=present)

    def refresh_hz(self, hz):
        return self.event(refresh_hz=hz)

    def interaction_profile(self, path):
        return self.event(interaction_profile=path)

    def lose_session(self, lost_after_s=None):
        return self.event(session_loss={} if lost_after_s is None else {"lost_after_s": lost_after_s})

    def lose_instance(self, lost_after_s=0.0):
        return self.event(instance_loss={"lost_after_s": lost_after_s})

    def refuse(self, call, result, **how):
        """refuse("xrEndFrame", "XR_ERROR_OUT_OF_MEMORY", nth=2, times=3), or for_s=1.5."""
        return self.event(refuse={"call": call, "result": result, **how})


def _parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("socket")
    parser.add_argument("--timeout", type=float, default=10.0, help="seconds to wait for a reply")
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("state", "pause", "resume"):
        commands.add_parser(name)
    step = commands.add_parser("step")
    step.add_argument("frames", type=int, nargs="?", default=1)
    wait = commands.add_parser("wait")
    wait.add_argument("condition", type=json.loads, help='such as {"frame": 300}')
    picture = commands.add_parser("picture")
    picture.add_argument("eye", choices=("left", "right"))
    picture.add_argument("file")
    recenter = commands.add_parser("recenter")
    recenter.add_argument("--space", choices=("local", "stage"), default="local")
    recenter.add_argument("--no-pose", action="store_true", help="the new pose is not told")
    session = commands.add_parser("session")
    session.add_argument("state", choices=("focused", "visible", "synchronized", "stopped", "exiting"))
    presence = commands.add_parser("user-presence")
    presence.add_argument("present", choices=("true", "false"))
    refresh = commands.add_parser("refresh-hz")
    refresh.add_argument("hz", type=float)
    profile = commands.add_parser("interaction-profile")
    profile.add_argument("path")
    for name in ("lose-session", "lose-instance"):
        lose = commands.add_parser(name)
        lose.add_argument("--after", type=float, help="seconds from pending to lost")
    refuse = commands.add_parser("refuse")
    refuse.add_argument("call")
    refuse.add_argument("result")
    apply = commands.add_parser("apply")
    apply.add_argument("fragment", type=json.loads, help="JSON")
    return parser.parse_args(arguments)


def _run(mock, given):
    if given.command == "wait":
        return mock.wait(**given.condition)
    if given.command == "picture":
        with open(given.file, "wb") as file:
            file.write(mock.picture(given.eye))
        return {"ok": True}
    if given.command == "recenter":
        return mock.recenter(space=given.space, pose_valid=not given.no_pose)
    if given.command == "user-presence":
        return mock.user_presence(given.present == "true")
    if given.command == "lose-session":
        return mock.lose_session(given.after)
    if given.command == "lose-instance":
        return mock.lose_instance(given.after or 0.0)
    if given.command == "refuse":
        return mock.refuse(given.call, given.result)
    one_argument = {"step": "frames", "session": "state", "refresh-hz": "hz",
                    "interaction-profile": "path", "apply": "fragment"}
    method = getattr(mock, given.command.replace("-", "_"))
    if given.command in one_argument:
        return method(getattr(given, one_argument[given.command]))
    return method()


def main(arguments=None):
    given = _parse(arguments)
    try:
        with Client(given.socket, given.timeout) as mock:
            print(json.dumps(_run(mock, given), indent=1))
    except (MockError, OSError) as error:
        print(f"xrmock: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
