"""The mirror shows a run of hello_xr live: the composed pictures of both eyes. It reports when the run has ended.

Needs hello_xr, Xvfb and tkinter. Without one of them the test is skipped (exit status 77).
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).parents[4] / "xr/mock/python"))

SKIPPED = 77


def start_display():
    """A virtual X server on a free display."""
    read_end, write_end = os.pipe()
    server = subprocess.Popen(["Xvfb", "-displayfd", str(write_end), "-screen", "0", "1400x800x24"],
                              pass_fds=[write_end], stderr=subprocess.DEVNULL)
    os.close(write_end)
    with os.fdopen(read_end) as numbers:
        os.environ["DISPLAY"] = ":" + numbers.readline().strip()
    return server


def start_run(socket):
    # hello_xr quits when its input ends.
    return subprocess.Popen(["hello_xr", "-g", "Vulkan2"], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL,
                            stderr=subprocess.DEVNULL, env={**os.environ, "XRMOCK_CONTROL": socket})


def until(window, done, what, most_s=30):
    deadline = time.monotonic() + most_s
    while not done():
        assert time.monotonic() < deadline, what
        window.update()
        time.sleep(0.01)


def colours(image):
    step = max(1, image.width() // 40)
    return [image.get(x, y) for y in range(0, image.height(), step) for x in range(0, image.width(), step)]


def check(mirror_module, socket):
    mirror = mirror_module.Mirror(socket, "both", 20, 1)
    window = mirror.window
    until(window, lambda: "no run" in mirror.status["text"], "it says that there is no run yet")
    run = start_run(socket)
    try:
        until(window, lambda: len(mirror.images) == 2, "both eyes appear")
        frame = int(mirror.status["text"].split()[1])
        until(window, lambda: mirror.status["text"].startswith("frame") and
              int(mirror.status["text"].split()[1]) > frame + 3, "the pictures go on")
        left, right = colours(mirror.images["left"]), colours(mirror.images["right"])
        assert mirror.images["left"].width() == 640, mirror.images["left"].width()
        assert len(set(left)) > 3, "hello_xr's cubes are seen before its background"
        assert left != right, "each eye has its own picture"
        mirror.show("right")
        window.update()
        assert not mirror.panes["left"].winfo_ismapped() and mirror.panes["right"].winfo_ismapped()
    finally:
        run.kill()
        run.wait()
    until(window, lambda: "no run" in mirror.status["text"], "it says that the run has ended")
    window.destroy()


def main():
    for program in ("hello_xr", "Xvfb"):
        if shutil.which(program) is None:
            print(f"skipped: {program} is not installed")
            return SKIPPED
    try:
        import mirror
    except ImportError as error:
        print(f"skipped: {error}")
        return SKIPPED
    server = start_display()
    try:
        with tempfile.TemporaryDirectory() as folder:
            check(mirror, os.path.join(folder, "run.sock"))
    finally:
        server.terminate()
        server.wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())
