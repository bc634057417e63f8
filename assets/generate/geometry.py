# SPDX-License-Identifier: Apache-2.0
"""Surfaces, each of one material: boxes with bevels, lathes, sweeps, screens. Metres; triangles are counter-clockwise
seen from outside."""
import math

from vectors import add, cross, dot, scale, sub, turned, unit


def linear(c):
    return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4


class Part:
    """Triangles of one material. `blockers` are boxes (low, high) that shade nearby surfaces, see shade.py."""

    def __init__(self, name, srgb, metallic=0.0, roughness=0.5, emission=0.0):
        self.name = name
        self.colour = [round(linear(c / 255.0), 5) for c in srgb] + [1.0]
        self.metallic, self.roughness, self.emission = metallic, roughness, emission
        self.positions, self.normals, self.uvs, self.indices, self.blockers = [], [], [], [], []
        self.open = []  # light that reaches a vertex, 0 to 1; filled in by shade.py

    def vertex(self, p, n, uv=(0.0, 0.0)):
        self.positions.append(p)
        self.normals.append(unit(n))
        self.uvs.append(uv)
        return len(self.positions) - 1

    def quad(self, a, b, c, d):
        self.indices += [a, b, c, a, c, d]

    def polygon(self, points):
        """A flat convex polygon."""
        n = cross(sub(points[1], points[0]), sub(points[2], points[0]))
        ids = [self.vertex(p, n) for p in points]
        for i in range(1, len(ids) - 1):
            self.indices += [ids[0], ids[i], ids[i + 1]]

    def sheet(self, corner, across, up, columns=1, rows=1):
        """A flat rectangle in columns and rows, with texture coordinates whose v points down."""
        n = cross(across, up)
        ids = [[self.vertex(add(corner, add(scale(across, i / columns), scale(up, j / rows))), n,
                            (i / columns, 1.0 - j / rows)) for i in range(columns + 1)] for j in range(rows + 1)]
        for j in range(rows):
            for i in range(columns):
                self.quad(ids[j][i], ids[j][i + 1], ids[j + 1][i + 1], ids[j + 1][i])

    def box(self, low, high, bevel=0.004, steps=1, blocks=True):
        """A box with flat faces whose edges are rounded by `bevel`, so that the edges catch the light."""
        middle = scale(add(low, high), 0.5)
        bevel = min([bevel] + [0.49 * (h - l) for l, h in zip(low, high)])
        half = tuple(0.5 * (h - l) - bevel for l, h in zip(low, high))
        rows = []
        for up in [i / steps for i in range(-steps, 1)] + [i / steps for i in range(0, steps + 1)]:
            lower = len(rows) <= steps
            ring = []
            for corner in range(4):
                for i in range(steps + 1):
                    around = math.pi / 2 * (corner + i / steps)
                    cu = math.cos(math.pi / 2 * up)
                    n = (cu * math.cos(around), math.sin(math.pi / 2 * up), -cu * math.sin(around))
                    sx, sz = ((1, -1), (-1, -1), (-1, 1), (1, 1))[corner]
                    at = (middle[0] + sx * half[0], middle[1] + (-half[1] if lower else half[1]),
                          middle[2] + sz * half[2])
                    ring.append(self.vertex(add(at, scale(n, bevel)), n))
            rows.append(ring)
        count = len(rows[0])
        for a, b in zip(rows, rows[1:]):
            for i in range(count):
                j = (i + 1) % count
                self.quad(a[i], a[j], b[j], b[i])
        for i in range(1, count - 1):
            self.indices += [rows[-1][0], rows[-1][i], rows[-1][i + 1], rows[0][0], rows[0][i + 1], rows[0][i]]
        if blocks:
            self.blockers.append((low, high))

    def lathe(self, runs, sides, centre=(0.0, 0.0, 0.0), axis=1, blocks=True):
        """Surface of revolution. `runs` are lists of (radius, height). A surface is smooth within a run and has a
        crease between runs. Winding: a run of increasing height faces away from the axis; a run of decreasing radius
        faces the +axis direction."""
        def place(u, v, h):
            p = {0: (h, u, v), 1: (v, h, u), 2: (u, v, h)}[axis]
            return add(p, centre)
        for run in runs:
            rings = []
            for k, (r, h) in enumerate(run):
                before, after = run[max(k - 1, 0)], run[min(k + 1, len(run) - 1)]
                nr, nh = after[1] - before[1], -(after[0] - before[0])
                ring = []
                for i in range(sides):
                    c, s = math.cos(2 * math.pi * i / sides), math.sin(2 * math.pi * i / sides)
                    ring.append(self.vertex(place(r * c, r * s, h), sub(place(nr * c, nr * s, nh), centre)))
                rings.append(ring)
            for k, (a, b) in enumerate(zip(rings, rings[1:])):
                for i in range(sides):
                    j = (i + 1) % sides
                    if run[k][0] > 0:
                        self.indices += [a[i], a[j], b[j]]
                    if run[k + 1][0] > 0:
                        self.indices += [a[i], b[j], b[i]]
        if blocks:
            points = [p for run in runs for p in run]
            r, h0, h1 = 0.8 * max(p[0] for p in points), min(p[1] for p in points), max(p[1] for p in points)
            corners = [place(-r, -r, h0), place(r, r, h1)]
            self.blockers.append((tuple(map(min, *corners)), tuple(map(max, *corners))))

    def rod(self, radius, low, high, sides=16, centre=(0.0, 0.0, 0.0), axis=1, bevel=None):
        """A closed cylinder with bevelled ends."""
        b = min(0.2 * radius, 0.5 * (high - low)) if bevel is None else bevel
        self.lathe([[(0.0, low), (radius - b, low)], [(radius - b, low), (radius, low + b)],
                    [(radius, low + b), (radius, high - b)], [(radius, high - b), (radius - b, high)],
                    [(radius - b, high), (0.0, high)]], sides, centre, axis)

    def sweep(self, section, frames, caps=True):
        """Moves a closed section [(x, y, normal x, normal y)], counter-clockwise, along frames [(origin, x axis, y
        axis)]. x cross y of each frame points along the path."""
        rings = [[self.vertex(add(o, add(scale(ax, x), scale(ay, y))), add(scale(ax, nx), scale(ay, ny)))
                  for x, y, nx, ny in section] for o, ax, ay in frames]
        n = len(section)
        for a, b in zip(rings, rings[1:]):
            for i in range(n):
                j = (i + 1) % n
                if section[i][:2] != section[j][:2]:
                    self.quad(a[i], a[j], b[j], b[i])
        if not caps:
            return
        for ring, (_, ax, ay), sign in ((rings[0], frames[0], -1), (rings[-1], frames[-1], 1)):
            ids = [self.vertex(self.positions[i], scale(cross(ax, ay), sign)) for i in ring]
            for i in range(1, n - 1):
                if sign > 0:
                    self.indices += [ids[0], ids[i], ids[i + 1]]
                else:
                    self.indices += [ids[0], ids[i + 1], ids[i]]

    def tube(self, radius, points, sides=10, up=(0.0, 1.0, 0.0), caps=True):
        """A round tube along points; radius may be a list, one for each point."""
        frames = frames_along(points, up)
        if not isinstance(radius, (list, tuple)):
            self.sweep(circle(radius, sides), frames, caps)
            return
        self.sweep(circle(1.0, sides), [(o, scale(x, r), scale(y, r)) for (o, x, y), r in zip(frames, radius)], caps)

    def place(self, degrees=0.0, axis=1, offset=(0.0, 0.0, 0.0), first=0):
        """Rotates all vertices from index `first` on about an axis through the origin, then shifts them."""
        for i in range(first, len(self.positions)):
            self.positions[i] = add(turned(self.positions[i], axis, degrees), offset)
            self.normals[i] = turned(self.normals[i], axis, degrees)


def circle(radius, sides):
    angles = [2 * math.pi * i / sides for i in range(sides)]
    return [(radius * math.cos(a), radius * math.sin(a), math.cos(a), math.sin(a)) for a in angles]


def rounded_rectangle(width, height, bevel, steps=2):
    points = []
    for corner, (sx, sy) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        for i in range(steps + 1):
            a = math.pi / 2 * (corner + i / steps)
            points.append((sx * (0.5 * width - bevel) + bevel * math.cos(a),
                           sy * (0.5 * height - bevel) + bevel * math.sin(a), math.cos(a), math.sin(a)))
    return points


def frames_along(points, up):
    """Frames perpendicular to a polyline, without twist along it."""
    frames, x = [], None
    for i, p in enumerate(points):
        way = unit(sub(points[min(i + 1, len(points) - 1)], points[max(i - 1, 0)]))
        x = x or cross(up, way)
        x = unit(sub(x, scale(way, dot(x, way))))
        frames.append((p, x, cross(way, x)))
    return frames


def curve(points, steps=6):
    """A smooth line through points (Catmull and Rom)."""
    ends = [points[0]] + list(points) + [points[-1]]
    out = []
    for a, b, c, d in zip(ends, ends[1:], ends[2:], ends[3:]):
        for i in range(steps):
            t = i / steps
            out.append(tuple(0.5 * (2 * q + (r - p) * t + (2 * p - 5 * q + 4 * r - s) * t * t +
                                    (3 * q - p - 3 * r + s) * t ** 3) for p, q, r, s in zip(a, b, c, d)))
    return out + [points[-1]]
