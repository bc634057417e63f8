#!/usr/bin/env python3
"""Shows what the eyes see of a run of the mock OpenXR runtime, in a window.

    XRMOCK_CONTROL=/tmp/run.sock hello_xr -g Vulkan2 &
    python3 mirror.py /tmp/run.sock

Keys: l left eye, r right eye, b both, q quit. The window may be opened before the run and outlives it. Needs
tkinter (Debian: python3-tk).
"""
import argparse
import base64
import queue
import threading
import time
import tkinter

import xrmock

EYES = {"left": ("left",), "right": ("right",), "both": ("left", "right")}


class Reader(threading.Thread):
    """Asks for one picture after the other; `pictures` gets (eye, frame, png), or (None, reason, None)."""

    def __init__(self, path, eyes, most_per_s):
        super().__init__(daemon=True)
        self.path = path
        self.eyes = eyes  # may be replaced at any time
        self.pause_s = 1 / most_per_s
        self.pictures = queue.Queue(maxsize=4)  # a slow window slows down the requests, not the run

    def run(self):
        while True:
            try:
                with xrmock.Client(self.path) as mock:
                    self._ask(mock)
            except (OSError, xrmock.MockError) as error:
                self.pictures.put((None, str(error), None))
                time.sleep(0.5)

    def _ask(self, mock):
        while True:
            eyes = self.eyes
            # Request both at once, so that both eyes show the same frame.
            requests = [(eye, mock.send(picture={"eye": eye})) for eye in eyes]
            for eye, request in requests:
                reply = mock.receive(request)
                self.pictures.put((eye, reply["frame"], base64.b64decode(reply["png"])))
            time.sleep(self.pause_s)


class Mirror:
    def __init__(self, path, eyes, most_per_s, shrink):
        self.window = tkinter.Tk()
        self.window.title(f"xrmock: {path}")
        self.window.configure(background="black")
        self.shrink = shrink
        self.images = {}
        self.panes = {eye: tkinter.Label(self.window, background="black", borderwidth=0)
                      for eye in ("left", "right")}
        self.status = tkinter.Label(self.window, anchor="w", text=f"waiting for {path}")
        self.status.grid(row=1, column=0, columnspan=2, sticky="we")
        self.reader = Reader(path, EYES[eyes], most_per_s)
        self.show(eyes)
        for key, choice in (("l", "left"), ("r", "right"), ("b", "both")):
            self.window.bind(key, lambda _, chosen=choice: self.show(chosen))
        self.window.bind("q", lambda _: self.window.destroy())
        self.reader.start()
        self.window.after(0, self.take)

    def show(self, eyes):
        self.reader.eyes = EYES[eyes]
        for column, (eye, pane) in enumerate(self.panes.items()):
            if eye in EYES[eyes]:
                pane.grid(row=0, column=column, padx=2)
            else:
                pane.grid_remove()

    def take(self):
        while not self.reader.pictures.empty():
            eye, frame, png = self.reader.pictures.get()
            if eye is None:
                self.status.configure(text=f"no run: {frame}")
                continue
            image = tkinter.PhotoImage(master=self.window, data=png)
            if self.shrink > 1:
                image = image.subsample(self.shrink)
            self.images[eye] = image  # Tk keeps no reference of its own
            self.panes[eye].configure(image=image)
            self.status.configure(text=f"frame {frame}")
        self.window.after(10, self.take)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("socket")
    parser.add_argument("--eyes", choices=tuple(EYES), default="both")
    parser.add_argument("--fps", type=float, default=20.0, help="pictures a second, at most")
    parser.add_argument("--shrink", type=int, default=1, help="show every nth pixel")
    given = parser.parse_args()
    Mirror(given.socket, given.eyes, given.fps, given.shrink).window.mainloop()


if __name__ == "__main__":
    main()
