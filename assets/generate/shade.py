# SPDX-License-Identifier: Apache-2.0
"""Computes how much of the room's light reaches each vertex past the boxes of the same object."""
import math

from vectors import add, cross, scale, unit

RAYS = 24
START = 0.004  # metres from the surface


def hemisphere():
    """Directions about +z with a cosine-weighted density."""
    golden = math.pi * (3.0 - math.sqrt(5.0))
    rays = []
    for i in range(RAYS):
        s = (i + 0.5) / RAYS
        rays.append((math.sqrt(s) * math.cos(golden * i), math.sqrt(s) * math.sin(golden * i), math.sqrt(1.0 - s)))
    return rays


def hits(origin, way, boxes, reach):
    """Distance to the nearest box, or `reach`. A box that contains the origin is ignored."""
    nearest = reach
    for low, high in boxes:
        enter, leave = 0.0, nearest
        for o, d, a, b in zip(origin, way, low, high):
            if abs(d) < 1e-9:
                if o < a or o > b:
                    leave = -1.0
                    break
                continue
            t0, t1 = (a - o) / d, (b - o) / d
            if t0 > t1:
                t0, t1 = t1, t0
            enter, leave = max(enter, t0), min(leave, t1)
            if enter > leave:
                break
        if 0.0 < enter <= leave:
            nearest = enter
    return nearest


def shade(parts, reach=0.35, floor=None, least=0.25, extra=()):
    """Sets `open` of every part. `floor`: height of a floor that blocks light from below. `extra`: additional
    boxes."""
    boxes = [b for part in parts for b in part.blockers] + list(extra)
    if floor is not None:
        boxes.append(((-99.0, floor - 1.0, -99.0), (99.0, floor, 99.0)))
    rays = hemisphere()
    for part in parts:
        known = {}
        part.open = []
        for p, n in zip(part.positions, part.normals):
            key = tuple(round(x, 4) for x in p + n)
            if key not in known:
                x = unit(cross((0.0, 1.0, 0.0) if abs(n[1]) < 0.9 else (1.0, 0.0, 0.0), n))
                y = cross(n, x)
                start = add(p, scale(n, START))
                near = [b for b in boxes if all(l - reach < s < h + reach for l, h, s in zip(*b, start))]
                total = 0.0
                for u, v, w in rays:
                    way = add(add(scale(x, u), scale(y, v)), scale(n, w))
                    total += math.sqrt(hits(start, way, near, reach) / reach)
                known[key] = max(least, total / RAYS)
            part.open.append(known[key])
