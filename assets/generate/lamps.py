# SPDX-License-Identifier: Apache-2.0
"""Surgical lamp. Node `head`: the light's centre is at the origin and shines along -z. Node `yoke`: carries the head;
y is up, and the arm ends 0.42 m above the origin. Node `arm`: a bar of unit length along x at y = 0. Node `post`:
hangs from the ceiling (y = 0), one unit long, and is scaled to fit."""
import math

from geometry import Part, curve
from gltf import write
from shade import shade

WHITE, DARK = (226, 229, 229), (62, 68, 74)


def head():
    shell, dark = Part("shell", WHITE, 0.0, 0.28), Part("rim", DARK, 0.0, 0.4)
    glass, led = Part("glass", (196, 202, 204), 0.0, 0.15, 0.55), Part("led", (255, 248, 232), 0.0, 0.4, 1.0)
    grip = Part("grip", (64, 140, 156), 0.0, 0.45)
    shell.lathe([[(0.315, 0.004), (0.325, 0.02), (0.318, 0.045), (0.27, 0.072), (0.16, 0.092), (0.0, 0.098)]], 48,
                axis=2)
    dark.lathe([[(0.295, -0.004), (0.313, -0.004)], [(0.313, -0.004), (0.318, 0.006)]], 48, axis=2)
    glass.lathe([[(0.0, 0.0), (0.296, 0.0)]], 48, axis=2, blocks=False)
    for count, radius in ((6, 0.10), (12, 0.185), (18, 0.262)):
        for i in range(count):
            a = 2 * math.pi * (i + 0.5) / count
            led.lathe([[(0.0, -0.004), (0.024, -0.002)]], 10, (radius * math.cos(a), radius * math.sin(a), 0.0), 2,
                      blocks=False)
    grip.lathe([[(0.0, -0.135), (0.012, -0.133), (0.017, -0.12), (0.016, -0.05), (0.024, -0.03), (0.034, -0.006)]], 24,
               axis=2)
    return [shell, dark, glass, led, grip]


def yoke():
    """A half ring through the head's horizontal axis, and the tube above it."""
    shell, joint = Part("yoke", WHITE, 0.0, 0.3), Part("joint", (170, 176, 180), 0.6, 0.35)
    points = [(0.355 * math.cos(a), 0.355 * math.sin(a), 0.0)
              for a in (math.pi * i / 20 for i in range(21))]
    shell.tube(0.017, points, 12, up=(0.0, 0.0, 1.0))
    for side in (-1, 1):
        low, high = sorted((0.318 * side, 0.385 * side))
        joint.rod(0.026, low, high, 16, axis=0)
    joint.rod(0.034, 0.335, 0.42, 20, bevel=0.008)
    return [shell, joint]


def make():
    arm, joint = Part("arm", WHITE, 0.0, 0.3), Part("joint", (170, 176, 180), 0.6, 0.35)
    arm.tube(0.032, [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)], 18)
    for x in (0.0, 1.0):
        joint.rod(0.05, -0.055, 0.055, 22, (x, 0.0, 0.0), bevel=0.012)
    post, cup = Part("post", WHITE, 0.0, 0.3), Part("cup", WHITE, 0.0, 0.35)
    post.rod(0.036, -1.0, 0.0, 20)
    cup.lathe([[(0.05, -0.16), (0.07, -0.14), (0.12, -0.03), (0.15, 0.0)]], 32)
    bars = [arm, joint]
    nodes = {"head": head(), "yoke": yoke(), "arm": bars, "post": [post, cup]}
    for name in ("head", "yoke"):
        shade(nodes[name], reach=0.2)
    write("rooms", "lamp", nodes)
