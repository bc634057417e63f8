# SPDX-License-Identifier: Apache-2.0
"""A gloved right hand that points. The pad of the index finger is at the origin; +z points along the finger toward the
hand, +y to the back of the hand. The shape is a smooth blend of capsules. The mesh is the zero level of their
distance, made with surface nets (Gibson 1998)."""
import math

from geometry import Part
from gltf import write
from vectors import add, cross, dot, length, scale, sub, unit

CELL = 0.0041

# (start, end, radius at start, radius at end) of each capsule, millimetres, x toward the thumb.
BONES = [
    ((0, 8, 6), (0, 10, 26), 7.6, 8.0), ((0, 10, 26), (-1, 11, 50), 8.2, 8.8), ((-1, 11, 50), (-4, 8, 94), 9.0, 10.5),
    # palm
    ((-6, 4, 96), (-14, 0, 160), 12.5, 15.0), ((-24, 3, 98), (-24, 0, 162), 12.5, 15.0),
    ((-42, 1, 102), (-34, 0, 162), 12.0, 14.5), ((-58, -3, 108), (-42, -1, 164), 11.0, 13.5),
    # curled fingers: middle, ring, little
    ((-24, 3, 94), (-23, -14, 56), 10.2, 9.2), ((-23, -14, 56), (-21, -34, 68), 9.2, 8.6), ((-21, -34, 68), (-20, -33, 88), 8.4, 8.0),
    ((-43, 0, 98), (-41, -18, 64), 9.8, 8.8), ((-41, -18, 64), (-37, -36, 76), 8.8, 8.2), ((-37, -36, 76), (-35, -33, 94), 8.0, 7.6),
    ((-59, -5, 106), (-57, -21, 78), 8.6, 7.8), ((-57, -21, 78), (-51, -35, 88), 7.8, 7.2), ((-51, -35, 88), (-48, -32, 103), 7.0, 6.8),
    # thumb across the curled fingers
    ((-8, -4, 150), (10, -18, 122), 14.0, 11.5), ((10, -18, 122), (8, -34, 92), 11.0, 9.6), ((8, -34, 92), (-8, -42, 74), 9.4, 8.2),
    # wrist
    ((-26, 0, 160), (-28, -2, 200), 21.0, 22.0), ((-16, 0, 166), (-20, -2, 200), 17.0, 19.0),
]


def capsule(p, a, b, ra, rb):
    ab, ap = sub(b, a), sub(p, a)
    t = max(0.0, min(1.0, sum(x * y for x, y in zip(ap, ab)) / sum(x * x for x in ab)))
    d = sub(ap, scale(ab, t))
    return math.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) - (ra + (rb - ra) * t)


def distance(p):
    """Signed distance in millimetres. The blend between bones is small, so that creases remain between the fingers."""
    blend = 4.0
    total, nearest = 0.0, 1e9
    for a, b, ra, rb in BONES:
        d = capsule(p, a, b, ra, rb)
        nearest = min(nearest, d)
        if d < 40.0:
            total += math.exp(-d / blend)
    return -blend * math.log(total) if total > 1e-30 else nearest


def surface(part, low, high, cell):
    """Adds the zero level of `distance` in the box from low to high (millimetres) to the part."""
    dims = [int(math.ceil((h - l) / cell)) + 1 for l, h in zip(low, high)]

    def at(i, j, k):
        return (low[0] + cell * i, low[1] + cell * j, low[2] + cell * k)
    # The distance changes by at most 1 mm per mm, so cells that are far away on a coarse grid need no finer evaluation.
    values = {}
    coarse = 4
    reach = cell * (coarse * 1.8 + 1.5) + 6.0
    for i in range(0, dims[0], coarse):
        for j in range(0, dims[1], coarse):
            for k in range(0, dims[2], coarse):
                far = abs(distance(at(i, j, k))) > reach
                sign = math.copysign(1e3, distance(at(i, j, k))) if far else 0.0
                for x in range(i, min(i + coarse, dims[0])):
                    for y in range(j, min(j + coarse, dims[1])):
                        for z in range(k, min(k + coarse, dims[2])):
                            values[x, y, z] = sign if far else distance(at(x, y, z))
    ids = {}
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    edges = [(a, b) for a in corners for b in corners if a < b and sum(abs(p - q) for p, q in zip(a, b)) == 1]
    for i in range(dims[0] - 1):
        for j in range(dims[1] - 1):
            for k in range(dims[2] - 1):
                d = {c: values[i + c[0], j + c[1], k + c[2]] for c in corners}
                if all(v > 0 for v in d.values()) or all(v <= 0 for v in d.values()):
                    continue
                crossings = []
                for a, b in edges:
                    if (d[a] > 0) != (d[b] > 0):
                        t = d[a] / (d[a] - d[b])
                        crossings.append(tuple(p + (q - p) * t for p, q in zip(a, b)))
                mean = tuple(sum(c[n] for c in crossings) / len(crossings) for n in range(3))
                p = add(at(i, j, k), scale(mean, cell))
                h = 0.5
                n = unit(tuple(distance(add(p, o)) - distance(sub(p, o)) for o in ((h, 0, 0), (0, h, 0), (0, 0, h))))
                p = sub(p, scale(n, 0.4 * distance(p)))
                ids[i, j, k] = part.vertex(scale(p, 1e-3), n)
    for (i, j, k), d in values.items():
        for axis in range(3):
            step = tuple(int(axis == n) for n in range(3))
            other = values.get((i + step[0], j + step[1], k + step[2]))
            if other is None or (d > 0) == (other > 0):
                continue
            u, v = [tuple(int(n == (axis + m) % 3) for n in range(3)) for m in (1, 2)]
            cells = [sub(sub((i, j, k), scale(u, a)), scale(v, b)) for a, b in ((1, 1), (0, 1), (0, 0), (1, 0))]
            corners4 = [ids.get(tuple(int(c) for c in cell_)) for cell_ in cells]
            if None in corners4:
                continue
            fold(part, corners4 if d <= 0 else corners4[::-1])


def fold(part, ids):
    """Adds a quad, split along the diagonal whose triangles agree better with the normals."""
    def worst(triangles):
        least = 1.0
        for t in triangles:
            a, b, c = (part.positions[i] for i in t)
            face = unit(cross(sub(b, a), sub(c, a)))
            least = min([least] + [dot(face, part.normals[i]) for i in t])
        return least
    a, b, c, d = ids
    for t in max(([(a, b, c), (a, c, d)], [(a, b, d), (b, c, d)]), key=worst):
        part.indices += t


def heal(part):
    """Collapses the shortest edge of each sliver that faces inward."""
    def face(t):
        a, b, c = (part.positions[i] for i in t)
        return cross(sub(b, a), sub(c, a))
    for _ in range(8):
        triangles = [part.indices[k:k + 3] for k in range(0, len(part.indices), 3)]
        bad = [t for t in triangles if len(set(t)) == 3 and sum(dot(face(t), part.normals[i]) for i in t) <= 0.0]
        for t in bad:
            a, b = min(((t[i], t[i - 1]) for i in range(3)),
                       key=lambda e: length(sub(part.positions[e[0]], part.positions[e[1]])))
            part.indices = [a if i == b else i for i in part.indices]
        if not bad:
            return


def make():
    glove = Part("glove", (222, 226, 232), 0.0, 0.42)
    surface(glove, (-78, -58, -6), (34, 28, 190), 1e3 * CELL)
    heal(glove)
    sleeve = Part("sleeve", (58, 128, 134), 0.0, 0.85)
    cuff = []
    for k in range(9):
        z = 0.176 + 0.014 * k
        r = 0.0300 + 0.0016 * k + (0.0022 if k in (1, 3) else 0.0) + 0.0012 * math.sin(2.7 * k)
        cuff.append((r, z))
    sleeve.lathe([[(0.0245, 0.178), (0.0285, 0.1755)] + cuff[0:], [cuff[-1], (0.036, cuff[-1][1] + 0.001), (0.0, cuff[-1][1] + 0.001)]],
                 28, (-0.026, -0.001, 0.0), 2)
    write("instruments", "hand", {"hand": [glove, sleeve]})
