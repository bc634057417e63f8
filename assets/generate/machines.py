# SPDX-License-Identifier: Apache-2.0
"""Machines with screens. Frame of each: y up; the screen faces +z. The ultrasound machine and the trolley stand on
y = 0; the X-ray and patient monitors hang from the ceiling, the screen's centre at the origin."""
import math

from geometry import Part, curve
from gltf import write
from shade import shade

BEZEL, DARK, STEEL, WHITE = (28, 31, 35), (52, 57, 63), (196, 200, 204), (222, 226, 226)


def screen(name, width, height, centre, tilt_deg=0.0):
    """A picture of width x height that faces +z and leans back by `tilt_deg`. The scene supplies its content."""
    part = Part("screen:" + name, (14, 16, 18), 0.0, 0.12)
    part.sheet((-0.5 * width, -0.5 * height, 0.0), (width, 0.0, 0.0), (0.0, height, 0.0))
    part.place(-tilt_deg, 0, centre)
    return part


def display(bezel, back, width, height, centre, tilt_deg=0.0, rim=0.018):
    """The case of a flat screen; its glass is 3 mm behind the rim's front."""
    first, first_back = len(bezel.positions), len(back.positions)
    w, h = 0.5 * width, 0.5 * height
    for low, high in (((-w - rim, -h - rim, -0.03), (w + rim, -h, 0.004)), ((-w - rim, h, -0.03), (w + rim, h + rim, 0.004)),
                      ((-w - rim, -h, -0.03), (-w, h, 0.004)), ((w, -h, -0.03), (w + rim, h, 0.004))):
        bezel.box(low, high, 0.004, blocks=False)
    bezel.box((-w - rim, -h - rim, -0.04), (w + rim, h + rim, -0.008), 0.006, blocks=False)
    back.box((-0.6 * w, -0.6 * h, -0.075), (0.6 * w, 0.6 * h, -0.035), 0.02, 2, blocks=False)
    bezel.place(-tilt_deg, 0, centre, first)
    back.place(-tilt_deg, 0, centre, first_back)


def ultrasound():
    white, dark = Part("case", WHITE, 0.0, 0.34), Part("trim", DARK, 0.0, 0.45)
    bezel, steel = Part("bezel", BEZEL, 0.0, 0.3), Part("steel", STEEL, 1.0, 0.3)
    black, cable = Part("tyre", (24, 25, 27), 0.0, 0.7), Part("cable", (206, 208, 206), 0.0, 0.5)
    keys, teal = Part("keys", (92, 99, 106), 0.0, 0.5), Part("accent", (40, 132, 148), 0.0, 0.35)
    dark.box((-0.25, 0.085, -0.30), (0.25, 0.15, 0.26), 0.03, 2)
    for x in (-0.215, 0.215):
        for z in (-0.25, 0.21):
            dark.rod(0.035, 0.07, 0.10, 10, (x, 0.0, z))
            for s in (-1, 1):
                black.rod(0.05, x + 0.017 * s - 0.011, x + 0.017 * s + 0.011, 14, (0.0, 0.05, z), 0, 0.005)
    white.box((-0.19, 0.14, -0.27), (0.19, 0.66, 0.12), 0.045, 3)
    dark.box((-0.13, 0.25, 0.115), (0.13, 0.60, 0.126), 0.006)
    for k in range(3):
        teal.box((-0.10, 0.33 + 0.09 * k, 0.124), (0.10, 0.336 + 0.09 * k, 0.129), 0.002, blocks=False)
    steel.box((-0.05, 0.64, -0.12), (0.05, 0.80, 0.0), 0.015, 2)
    # Console, leaning toward the user.
    first_white, first_keys, first_dark = len(white.positions), len(keys.positions), len(dark.positions)
    white.box((-0.24, -0.025, -0.20), (0.24, 0.025, 0.20), 0.022, 3)
    dark.box((-0.215, 0.023, -0.175), (0.215, 0.028, 0.155), 0.003, blocks=False)
    for row in range(4):
        for column in range(11):
            key(keys, (-0.19 + 0.0275 * column, 0.027, -0.155 + 0.026 * row), 0.022, 0.006, 0.020)
    for x in (0.13, 0.165, 0.20):
        keys.rod(0.012, 0.027, 0.046, 12, (x, 0.0, -0.11), bevel=0.003)
    keys.lathe([[(0.030, 0.028), (0.029, 0.037), (0.022, 0.048), (0.011, 0.055), (0.0, 0.057)]], 20, (0.0, 0.0, 0.055),
               blocks=False)
    for part, first in ((white, first_white), (keys, first_keys), (dark, first_dark)):
        part.place(10.0, 0, (0.0, 0.83, 0.10), first)
    white.blockers[-1] = ((-0.24, 0.79, -0.10), (0.24, 0.87, 0.30))
    white.tube(0.016, curve([(-0.20, 0.79, 0.27), (-0.20, 0.775, 0.335), (0.0, 0.772, 0.345), (0.20, 0.775, 0.335),
                             (0.20, 0.79, 0.27)], 4), 8)
    # Probe holders and a parked linear probe.
    dark.lathe([[(0.026, 0.79), (0.030, 0.86)], [(0.030, 0.86), (0.024, 0.86)], [(0.024, 0.86), (0.020, 0.80)]], 20,
               (-0.275, 0.0, 0.14), blocks=False)
    white.lathe([[(0.016, 0.80), (0.019, 0.89), (0.026, 0.93), (0.026, 0.955)], [(0.026, 0.955), (0.0, 0.957)]], 20,
                (-0.275, 0.0, 0.14), blocks=False)
    cable.tube(0.006, curve([(-0.275, 0.80, 0.14), (-0.28, 0.62, 0.16), (-0.27, 0.36, 0.15), (-0.22, 0.27, 0.13),
                             (-0.20, 0.40, 0.10), (-0.185, 0.50, 0.08)], 4), 6)
    # Arm and screen.
    steel.tube(0.022, curve([(0.0, 0.84, -0.07), (0.0, 0.98, -0.10), (0.0, 1.10, -0.10), (0.0, 1.24, -0.05)], 4), 12)
    display(bezel, dark, 0.470, 0.353, (0.0, 1.285, 0.03), 8.0)
    dark.box((-0.05, 1.20, -0.075), (0.05, 1.29, -0.03), 0.015, 2, blocks=False)
    parts = [white, dark, bezel, steel, black, cable, keys, teal]
    shade(parts, floor=0.0)
    parts.append(screen("ultrasound", 0.470, 0.353, (0.0, 1.285, 0.03), 8.0))
    write("rooms", "ultrasound", {"ultrasound": parts})


def key(part, low, width, height, depth):
    """A key: a frustum without a bottom."""
    (x, y, z), b = low, 0.003
    top = [(x + b, y + height, z + depth - b), (x + width - b, y + height, z + depth - b),
           (x + width - b, y + height, z + b), (x + b, y + height, z + b)]
    foot = [(x, y, z + depth), (x + width, y, z + depth), (x + width, y, z), (x, y, z)]
    part.polygon(top)
    for i in range(4):
        part.polygon([foot[i], foot[(i + 1) % 4], top[(i + 1) % 4], top[i]])


def boom(part, joint, height, reach):
    """An arm from behind the screen to the ceiling. The ceiling is `height` above the origin; the arm meets it `reach`
    behind the origin."""
    joint.rod(0.030, -0.075, 0.075, 18, (0.0, 0.0, -0.11))
    part.tube(0.020, [(0.0, 0.0, -0.06), (0.0, 0.0, -0.11)], 12)
    part.tube(0.024, curve([(0.0, 0.02, -0.11), (0.0, 0.30, -0.11), (0.0, 0.38, -0.14), (0.0, 0.40, -0.22)], 5), 14)
    part.tube(0.028, [(0.0, 0.40, -0.20), (0.0, 0.40, -reach)], 14)
    joint.rod(0.05, 0.34, 0.47, 20, (0.0, 0.0, -reach), bevel=0.01)
    part.rod(0.034, 0.45, height, 18, (0.0, 0.0, -reach))
    joint.lathe([[(0.05, height - 0.10), (0.06, height - 0.06), (0.10, height - 0.02), (0.11, height)]], 24,
                (0.0, 0.0, -reach))


def monitor(name, width, height, above, reach):
    bezel, dark = Part("bezel", BEZEL, 0.0, 0.3), Part("trim", DARK, 0.0, 0.4)
    arm, joint = Part("arm", WHITE, 0.0, 0.32), Part("joint", (168, 174, 178), 0.6, 0.35)
    display(bezel, dark, width, height, (0.0, 0.0, 0.0))
    bezel.blockers.append(((-0.5 * width, -0.5 * height, -0.06), (0.5 * width, 0.5 * height, -0.01)))
    boom(arm, joint, above, reach)
    if name == "xray":
        arm.tube(0.010, curve([(-0.16, -0.5 * height - 0.02, -0.02), (-0.16, -0.5 * height - 0.07, 0.01),
                               (0.16, -0.5 * height - 0.07, 0.01), (0.16, -0.5 * height - 0.02, -0.02)], 4), 10)
    parts = [bezel, dark, arm, joint]
    shade(parts)
    parts.append(screen(name, width, height, (0.0, 0.0, 0.0)))
    write("rooms", name + "_monitor" if name == "xray" else "patient_monitor", {name: parts})


def trolley():
    """An instrument table under a sterile cloth."""
    steel, cloth = Part("steel", STEEL, 1.0, 0.28), Part("cloth", (44, 112, 124), 0.0, 0.85)
    black, bowl = Part("tyre", (24, 25, 27), 0.0, 0.7), Part("bowl", (206, 210, 214), 1.0, 0.2)
    swab, syringe = Part("swab", (236, 238, 236), 0.0, 0.95), Part("syringe", (214, 226, 232), 0.0, 0.2)
    for x in (-0.34, 0.34):
        for z in (-0.19, 0.19):
            steel.rod(0.011, 0.06, 0.86, 12, (x, 0.0, z))
            black.rod(0.03, x - 0.01, x + 0.01, 14, (0.0, 0.03, z), 0, 0.004)
    steel.box((-0.34, 0.24, -0.19), (0.34, 0.255, 0.19), 0.004)
    steel.box((-0.36, 0.855, -0.21), (0.36, 0.868, 0.21), 0.004)
    drop(cloth, 0.375, 0.225, 0.871, 0.24)
    for k in range(4):
        swab.box((0.12, 0.874 + 0.006 * k, -0.10 + 0.002 * k), (0.20, 0.879 + 0.006 * k, -0.02 + 0.002 * k), 0.002,
                 blocks=False)
    bowl.lathe([[(0.0, 0.874), (0.045, 0.874)], [(0.045, 0.874), (0.070, 0.915), (0.076, 0.935)],
                [(0.076, 0.935), (0.073, 0.935)], [(0.073, 0.935), (0.066, 0.912), (0.043, 0.880)],
                [(0.043, 0.880), (0.0, 0.879)]], 28, (-0.20, 0.0, -0.06), blocks=False)
    for z in (0.04, 0.075):
        syringe.rod(0.009, -0.10, 0.0, 14, (0.06, 0.882, z), 0)
        syringe.rod(0.0025, -0.145, -0.10, 8, (0.06, 0.882, z), 0)
        syringe.rod(0.013, 0.0, 0.004, 14, (0.06, 0.882, z), 0)
        syringe.rod(0.005, 0.0, 0.05, 8, (0.06, 0.882, z), 0)
    parts = [steel, cloth, black, bowl, swab, syringe]
    shade(parts, floor=0.0)
    write("rooms", "trolley", {"trolley": parts})


def drop(cloth, half_x, half_z, top, fall):
    """A cloth over a table: flat on top, hanging in folds."""
    outline = []
    around = 112
    for i in range(around):
        a = 2 * math.pi * i / around
        c, s = math.cos(a), math.sin(a)
        k = (abs(c) ** 8 + abs(s) ** 8) ** (-1 / 8)
        outline.append((half_x * k * c, half_z * k * s, a))
    rows = [(0.985, 0.0, 0.0), (1.0, -0.004, 0.15), (1.006, -0.02, 0.5)] + \
        [(1.0, -fall * f, 0.5 + f) for f in (0.3, 0.65, 1.0)]
    points = []
    for size, down, fold in rows:
        ring = []
        for x, z, a in outline:
            wave = math.sin(19 * a) * 0.6 + math.sin(11 * a + 1.3) * 0.4
            r = math.hypot(x, z)
            out = 0.013 * (fold - 0.15) * wave if fold > 0.15 else 0.0
            hem = (0.012 * math.sin(3 * a) if fold > 1.4 else 0.0)
            ring.append(((size + out / r) * x, top + down + hem, (size + out / r) * z))
        points.append(ring)
    grid(cloth, points)
    middle = cloth.vertex((0.0, top + 0.001, 0.0), (0, 1, 0))
    ids = [cloth.vertex(p, (0, 1, 0)) for p in points[0]]
    for i in range(around):
        cloth.indices += [middle, ids[(i + 1) % around], ids[i]]


def grid(part, rings):
    """A smooth surface through closed rings. Seen from above, each ring lies outside the one before."""
    n = len(rings[0])
    normals = []
    for k, ring in enumerate(rings):
        before, after = rings[max(k - 1, 0)], rings[min(k + 1, len(rings) - 1)]
        row = []
        for i in range(n):
            along = tuple(b - a for a, b in zip(ring[i - 1], ring[(i + 1) % n]))
            down = tuple(b - a for a, b in zip(before[i], after[i]))
            row.append((down[1] * along[2] - down[2] * along[1], down[2] * along[0] - down[0] * along[2],
                        down[0] * along[1] - down[1] * along[0]))
            row[-1] = tuple(-c for c in row[-1])
        normals.append(row)
    ids = [[part.vertex(p, m) for p, m in zip(ring, row)] for ring, row in zip(rings, normals)]
    for a, b in zip(ids, ids[1:]):
        for i in range(n):
            part.quad(a[i], a[(i + 1) % n], b[(i + 1) % n], b[i])


def make():
    ultrasound()
    monitor("xray", 0.560, 0.420, 1.42, 0.62)
    monitor("monitor", 0.400, 0.300, 1.42, 0.55)
    trolley()
