# SPDX-License-Identifier: Apache-2.0
"""Points and directions as tuples of three."""
import math


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scale(a, s):
    return (a[0] * s, a[1] * s, a[2] * s)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def length(a):
    return math.sqrt(dot(a, a))


def unit(a):
    n = length(a) or 1.0
    return (a[0] / n, a[1] / n, a[2] / n)


def mix(a, b, t):
    return tuple(x + (y - x) * t for x, y in zip(a, b))


def turned(p, axis, degrees, about=(0.0, 0.0, 0.0)):
    """p, rotated about a coordinate axis (0, 1, 2) through `about`."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    q = list(sub(p, about))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    q[i], q[j] = c * q[i] - s * q[j], s * q[i] + c * q[j]
    return add(tuple(q), about)
