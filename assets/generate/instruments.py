# SPDX-License-Identifier: Apache-2.0
"""Needle, probe and scalpel. The origin is the point that touches the patient; +z points toward the hand."""
import math

from geometry import Part, curve
from gltf import write
from shade import shade


def ground_tip(node, facets):
    """A tip of radius 1 and length 1 with its point at the origin. `facets` 0: one plane cut, else a pyramid. Affine
    scaling gives any diameter and bevel."""
    sides = 24
    wall, ground = Part("steel", (208, 212, 216), 1.0, 0.22), Part("bevel", (232, 234, 236), 1.0, 0.12)
    low, high, rim = [], [], []
    for i in range(sides):
        angle = 2 * math.pi * i / sides
        x, y, closing = math.cos(angle), math.sin(angle), 1.0
        if facets:
            z = max(math.cos(angle - 2 * math.pi * k / facets) for k in range(facets))
        else:
            # The point of a plane cut would lie on the rim of the shaft. The first part is moved toward the axis, so
            # that the visible point is where the forces act.
            z = 0.5 * (1.0 - x)
            closing = math.sqrt(min(1.0, z / 0.3))
        rim.append((x * closing, y * closing, z))
        low.append(wall.vertex(rim[-1], (x, y, 0.0)))
        high.append(wall.vertex((x, y, 1.0), (x, y, 0.0)))
    for i in range(sides):
        j = (i + 1) % sides
        wall.quad(low[i], low[j], high[j], high[i])
    middle = (0.0, 0.0, 0.0) if facets else tuple(sum(p[k] for p in rim) / sides for k in range(3))
    for i in range(sides):
        ground.polygon([middle, rim[(i + 1) % sides], rim[i]])
    return {node: [wall, ground]}


def needle():
    """Parts of any needle with its stylet inserted. Shaft, tips and mark have radius 1 and length 1; the program scales
    them to the needle's dimensions and puts the hub at the end of the shaft. +z points toward the hub."""
    sides = 20
    steel = Part("steel", (208, 212, 216), 1.0, 0.22)
    steel.lathe([[(1.0, 0.0), (1.0, 1.0)]], sides, axis=2)
    mark = Part("marks", (30, 32, 36), 0.0, 0.6)
    mark.lathe([[(1.04, -0.5), (1.04, 0.5)]], sides, axis=2)
    hub = Part("hub", (226, 74, 60), 0.0, 0.28)
    hub.lathe([[(0.0, -0.004), (0.0016, -0.004)],
               [(0.0016, -0.004), (0.0022, 0.0), (0.0033, 0.006), (0.0036, 0.014)],
               [(0.0036, 0.014), (0.0052, 0.0142)],
               [(0.0052, 0.0142), (0.0056, 0.0147), (0.0056, 0.0185),
                (0.0052, 0.019)],
               [(0.0052, 0.019), (0.0, 0.019)]], 28, axis=2)
    for k in range(10):
        first = len(hub.positions)
        hub.box((0.0050, -0.0006, 0.0145), (0.0060, 0.0006, 0.0188), 0.0003, blocks=False)
        hub.place(36.0 * k, 2, first=first)
    stylet = Part("stylet", (206, 52, 44), 0.0, 0.3)
    stylet.lathe([[(0.0030, 0.018), (0.0030, 0.0215)],
                  [(0.0030, 0.0215), (0.0058, 0.0225)],
                  [(0.0058, 0.0225), (0.0062, 0.0235), (0.0060, 0.0285),
                   (0.0048, 0.0305), (0.0, 0.0312)]], 28, axis=2)
    stylet.box((0.0045, -0.0012, 0.0228), (0.0080, 0.0012, 0.0270), 0.0005, blocks=False)
    wings = Part("wings", (232, 96, 82), 0.0, 0.32)
    wings.box((-0.0130, -0.0010, 0.0045), (0.0130, 0.0010, 0.0125), 0.0009, 2, blocks=False)
    write("instruments", "needle", {"shaft": [steel], "mark": [mark], **ground_tip("tip_chiba", 0),
                                    **ground_tip("tip_trocar", 3), **ground_tip("tip_diamond", 4),
                                    "hub": [hub, stylet, wings]})


RAIL_DEG = 25.0  # of the needle guide, as in haptics/tools/guide.h


def rail(z):
    """The point of the needle guide's line at this height."""
    return (-0.030 - (z - 0.010) * math.tan(math.radians(RAIL_DEG)), 0.0, z)


def probe_parts(radius, lens_x, head):
    """A probe whose face has this radius. `lens_x`: half length of its lens. `head`: half length of the shell at its
    widest and of the sections above it. The centre of the lens is at the origin; x runs along the array, and the image
    plane is y = 0. The needle guide and the ridge that marks the picture's left side are at -x. There is no cable,
    which would end in mid-air or run through the drape."""
    lens, shell = Part("lens", (92, 98, 104), 0.0, 0.42), Part("shell", (226, 228, 224), 0.0, 0.3)
    grip, accent = Part("grip", (70, 78, 86), 0.0, 0.5), Part("accent", (40, 132, 148), 0.0, 0.35)
    guide = Part("guide", (92, 170, 186), 0.0, 0.3)
    half_y, corner_x, wide = 0.0085, 0.0078, head[0]

    def lift(x):
        return radius - math.sqrt(radius * radius - x * x)
    # The lens: an arc along x, rounded across y, with round corners.
    rows = []
    half_angle = math.asin(lens_x / radius)
    for i in range(25):
        a = -half_angle * math.cos(math.pi * i / 24)
        into = max(0.0, (abs(radius * math.sin(a)) - lens_x) / corner_x + 1.0)
        row = []
        for k in range(7):
            b = math.pi * (k / 6 - 0.5)
            y, sink = half_y * math.sqrt(1.04 - into * into) * math.sin(b), 0.004 * (1 - math.cos(b))
            n = (math.sin(a) * math.cos(b), math.sin(b), -math.cos(a) * math.cos(b))
            row.append(lens.vertex((radius * math.sin(a), y, radius * (1 - math.cos(a)) + sink), n))
        rows.append(row)
    for a, b in zip(rows, rows[1:]):
        for k in range(6):
            lens.quad(a[k], a[k + 1], b[k + 1], b[k])
    for row, side in ((rows[0], -1), (rows[-1], 1)):
        low = [lens.vertex(lens.positions[i], (side, 0, 0)) for i in row]
        high = [lens.vertex((lens.positions[i][0], lens.positions[i][1], lift(lens_x) + 0.0045), (side, 0, 0)) for i in row]
        for k in range(6):
            lens.quad(*((low[k], low[k + 1], high[k + 1], high[k]) if side > 0 else
                        (low[k], high[k], high[k + 1], low[k + 1])))

    # The body: rounded sections from head to handle. The lowest ones follow the lens.
    def section(half_x, half_w, corner, z, slope, bent):
        out = []
        for c, (sx, sy) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
            for i in range(6):
                t = math.pi / 2 * (c + i / 5)
                x, y = sx * (half_x - corner) + corner * math.cos(t), sy * (half_w - corner) + corner * math.sin(t)
                out.append(((x, y, z + (lift(x) if bent else 0.0)), (math.cos(t), math.sin(t), slope)))
            for i in range(1, 8 if sx == sy else 1):  # along the lens
                x = sx * (half_x - corner) * (1 - i / 4)
                out.append(((x, sy * half_w, z + (lift(x) if bent else 0.0)), (0.0, sy, slope)))
        return out

    def loft(part, sections, bent=0):
        ids = []
        for k, (hx, hw, corner, z) in enumerate(sections):
            b, a = sections[max(k - 1, 0)], sections[min(k + 1, len(sections) - 1)]
            slope = -(a[0] - b[0]) / max(1e-6, a[3] - b[3])
            ids.append([part.vertex(p, n) for p, n in section(hx, hw, corner, z, 0.7 * slope, k < bent)])
        n = len(ids[0])
        for a, b in zip(ids, ids[1:]):
            for i in range(n):
                part.quad(a[i], a[(i + 1) % n], b[(i + 1) % n], b[i])
    loft(shell, [(lens_x - 0.0005, 0.0078, 0.0070, 0.0032), (lens_x + 0.0006, 0.0086, 0.0078, 0.0032),
                 (lens_x + 0.0016, 0.0100, 0.0090, 0.0055), (wide, 0.0115, 0.0105, 0.0190), (wide, 0.0130, 0.0115, 0.0240),
                 (head[1], 0.0140, 0.0125, 0.036), (head[2], 0.0145, 0.0135, 0.050), (head[3], 0.0142, 0.0138, 0.062),
                 (0.0188, 0.0140, 0.0138, 0.074)], 3)
    loft(accent, [(0.0189, 0.0141, 0.0139, 0.074), (0.0189, 0.0141, 0.0139, 0.077)])
    loft(shell, [(0.0187, 0.0139, 0.0137, 0.077), (0.0180, 0.0138, 0.0136, 0.100), (0.0172, 0.0136, 0.0134, 0.125),
                 (0.0150, 0.0128, 0.0126, 0.138), (0.0115, 0.0108, 0.0106, 0.145), (0.0085, 0.0085, 0.0083, 0.147)])
    for side in (-1, 1):
        accent.box((-0.011, 0.0136 * side - 0.0012, 0.058), (-0.008, 0.0136 * side + 0.0012, 0.064), 0.0006, blocks=False)
    grip.lathe([[(0.0086, 0.1468), (0.0078, 0.149), (0.0052, 0.1508), (0.0, 0.1514)]], 20, axis=2)
    # The guide: a clip around the head and a channel around the needle's line.
    loft(guide, [(wide + 0.0012, 0.0140, 0.0120, 0.0215), (wide + 0.0014, 0.0145, 0.0125, 0.0235),
                 (wide + 0.0007, 0.0152, 0.0130, 0.0315), (wide, 0.0150, 0.0130, 0.0335)])
    guide.box((-0.0400, -0.0040, 0.0220), (0.0018 - wide, 0.0040, 0.0330), 0.0012, blocks=False)
    first = len(guide.positions)
    guide.lathe([[(0.0032, -0.012), (0.0036, -0.010), (0.0036, 0.012), (0.0046, 0.0165), (0.0046, 0.018)],
                 [(0.0046, 0.018), (0.0012, 0.016)]], 16, axis=2)
    guide.lathe([[(0.0, -0.012), (0.0032, -0.012)]], 16, axis=2)
    guide.place(-RAIL_DEG, 1, rail(0.0315), first)
    return [lens, shell, grip, accent, guide]


def probe():
    """An abdominal probe with a face of 60 mm radius and length, and one with a flat face of 40 mm."""
    write("instruments", "probe", {"probe": probe_parts(0.060, 0.0282, (0.0318, 0.0300, 0.0250, 0.0205)),
                                   "linear_probe": probe_parts(10.0, 0.0194, (0.0222, 0.0218, 0.0208, 0.0195))})


def scalpel():
    """Scalpel with an 11 blade: its point at the origin, the cutting edge toward -y, the handle along +z."""
    blade, handle = Part("blade", (214, 218, 222), 1.0, 0.16), Part("handle", (176, 181, 186), 1.0, 0.34)
    edge = Part("edge", (240, 242, 244), 1.0, 0.08)
    t = 0.0002
    back = [(0.0, 0.0), (0.0034, 0.028), (0.0034, 0.040)]      # (y, z) from the point along the back
    front = [(0.0, 0.0), (-0.0030, 0.026), (-0.0030, 0.040)]   # and along the cutting edge
    ground = [(-0.0001, 0.0010), (-0.0020, 0.026), (-0.0020, 0.040)]
    for s in (-1, 1):
        rows = [[(s * t, y, z) for y, z in line] for line in (back, ground)]
        for k in range(2):
            q = [rows[0][k], rows[1][k], rows[1][k + 1], rows[0][k + 1]]
            blade.polygon(q if s < 0 else q[::-1])
            e = [(s * t, *ground[k]), (0.0, *front[k]), (0.0, *front[k + 1]), (s * t, *ground[k + 1])]
            for three in (e[:3], [e[0], e[2], e[3]]):
                edge.polygon(three if s < 0 else three[::-1])
    for k in range(2):
        blade.polygon([(t, *back[k]), (-t, *back[k]), (-t, *back[k + 1]), (t, *back[k + 1])])
    handle.box((-0.0012, -0.0026, 0.034), (0.0012, 0.0030, 0.050), 0.0008, blocks=False)
    profile = [(0.0030, 0.0012, 0.046), (0.0052, 0.0019, 0.056), (0.0050, 0.0021, 0.080), (0.0043, 0.0021, 0.105),
               (0.0047, 0.0020, 0.140), (0.0050, 0.0019, 0.160), (0.0034, 0.0014, 0.166)]
    ids = []
    for w, h, z in profile:
        ids.append([handle.vertex((h * math.cos(a) * 1.2, w * math.sin(a), z), (w * math.cos(a), h * math.sin(a) * 0.8, 0.0))
                    for a in (2 * math.pi * i / 20 for i in range(20))])
    for a, b in zip(ids, ids[1:]):
        for i in range(20):
            handle.quad(a[i], a[(i + 1) % 20], b[(i + 1) % 20], b[i])
    for ring, sign in ((ids[0], -1), (ids[-1], 1)):
        cap = [handle.vertex(handle.positions[i], (0, 0, sign)) for i in ring]
        for i in range(1, 19):
            handle.indices += [cap[0], cap[i], cap[i + 1]] if sign > 0 else [cap[0], cap[i + 1], cap[i]]
    for k in range(9):
        for s in (-1, 1):
            handle.box((0.0020 * s - 0.0006, -0.0036, 0.066 + 0.004 * k), (0.0020 * s + 0.0006, 0.0036, 0.068 + 0.004 * k),
                       0.0004, blocks=False)
    write("instruments", "scalpel", {"scalpel": [blade, edge, handle]})


def make():
    needle()
    probe()
    scalpel()
