# SPDX-License-Identifier: Apache-2.0
"""The operating room: floor, walls, ceiling, doors and built-in objects. Frame: y up from the floor, origin at the
middle of the operating table, z toward the patient's head. The inside is bounded by HALF_X, HALF_Z and HEIGHT
(render/room/lighting uses the same numbers)."""
import math

from geometry import Part
from gltf import write
from shade import shade
from vectors import add, cross, scale, sub, unit

HALF_X, HALF_Z, HEIGHT = 3.4, 3.1, 3.0
LAMPLIT = 1.3
PANELS = [(x, z) for x in (-1.55, 1.55) for z in (-1.7, 0.0, 1.7)]  # centres of the ceiling's lights
PANEL_X, PANEL_Z = 0.30, 0.60
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def light_on(p, n):
    """Light at p with normal n, from the ceiling panels and reflected. It gives walls, floor and ceiling their slow
    gradients."""
    total = 0.0
    for x, z in PANELS:
        for dx in (-0.15, 0.15):
            for dz in (-0.3, 0.3):
                to = sub((x + dx, HEIGHT, z + dz), p)
                d2 = max(0.05, sum(c * c for c in to))
                way = unit(to)
                total += max(0.0, sum(a * b for a, b in zip(way, n))) * max(0.0, way[1]) / d2 * 0.09
    corner = 1.0
    for axis, half in ((0, HALF_X), (2, HALF_Z)):
        if abs(n[axis]) < 0.5:
            corner *= 1.0 - 0.30 * math.exp(-(half - abs(p[axis])) / 0.22)
    if abs(n[1]) < 0.5:
        corner *= (1.0 - 0.28 * math.exp(-p[1] / 0.20)) * (1.0 - 0.22 * math.exp(-(HEIGHT - p[1]) / 0.2))
    return corner * (0.58 + 0.42 * min(1.0, 1.15 * total))


def surface(part, corner, across, up, columns, rows):
    """A subdivided rectangle with the light at each of its vertices."""
    first = len(part.positions)
    part.sheet(corner, across, up, columns, rows)
    n = unit(cross(across, up))
    for p in part.positions[first:]:
        part.open.append(light_on(p, n))


def slab(part, low, high, bevel=0.004, room=None):
    """A built-in box. It is lit along its own normals or, if `room` is given, as if it faced in that direction."""
    first = len(part.positions)
    part.box(low, high, bevel, blocks=False)
    for p, n in zip(part.positions[first:], part.normals[first:]):
        part.open.append(light_on(p, room or n))


def wall_parts():
    floor, wall = Part("floor", (150, 165, 168), 0.0, 0.22), Part("wall", (222, 234, 232), 0.0, 0.55)
    band, ceiling = Part("band", (70, 142, 150), 0.0, 0.45), Part("ceiling", (240, 242, 240), 0.0, 0.8, 0.035)
    lit_floor = Part("floor", (150, 165, 168), 0.0, 0.22)
    skirting, light = Part("skirting", (84, 98, 102), 0.0, 0.4), Part("panel", (255, 251, 242), 0.0, 0.6, 1.0)
    frame, seam = Part("panel_frame", (188, 193, 194), 0.2, 0.45), Part("seam", (170, 188, 188), 0.0, 0.6)
    # The lamp lights only the middle of the floor.
    for x0, x1 in ((-HALF_X, -LAMPLIT), (-LAMPLIT, LAMPLIT), (LAMPLIT, HALF_X)):
        for z0, z1 in ((-HALF_Z, -LAMPLIT), (-LAMPLIT, LAMPLIT), (LAMPLIT, HALF_Z)):
            part = lit_floor if abs(x0 + x1) + abs(z0 + z1) < 0.01 else floor
            surface(part, (x0, 0.0, z1), (x1 - x0, 0.0, 0.0), (0.0, 0.0, z0 - z1), 7, 7)
    surface(ceiling, (-HALF_X, HEIGHT, -HALF_Z), (2 * HALF_X, 0.0, 0.0), (0.0, 0.0, 2 * HALF_Z), 12, 11)
    # Each wall: its lower left corner seen from inside, and the direction along it.
    for corner, along, span in (((-HALF_X, 0, HALF_Z), (0, 0, -1), 2 * HALF_Z), ((HALF_X, 0, -HALF_Z), (0, 0, 1), 2 * HALF_Z),
                                ((-HALF_X, 0, -HALF_Z), (1, 0, 0), 2 * HALF_X), ((HALF_X, 0, HALF_Z), (-1, 0, 0), 2 * HALF_X)):
        inward = cross(along, Y)

        def rectangle(part, s0, s1, y0, y1, off, columns, rows):
            at = add(add(add(corner, scale(along, s0)), (0, y0, 0)), scale(inward, off))
            surface(part, at, scale(along, s1 - s0), (0, y1 - y0, 0), columns, rows)
        rectangle(wall, 0, span, 0, HEIGHT, 0.0, 12, 10)
        rectangle(skirting, 0, span, 0, 0.11, 0.006, 12, 2)
        rectangle(band, 0, span, 0.94, 1.12, 0.005, 12, 1)
        for k in range(1, 5):
            s = span * k / 5
            rectangle(seam, s - 0.003, s + 0.003, 0.11, 0.94, 0.003, 1, 3)
            rectangle(seam, s - 0.003, s + 0.003, 1.12, HEIGHT, 0.003, 1, 4)
    for x, z in PANELS:
        surface(light, (x - PANEL_X, HEIGHT - 0.012, z - PANEL_Z), (2 * PANEL_X, 0, 0), (0, 0, 2 * PANEL_Z), 1, 1)
        for low, high in (((-PANEL_X - 0.03, -PANEL_Z - 0.03), (-PANEL_X, PANEL_Z + 0.03)),
                          ((PANEL_X, -PANEL_Z - 0.03), (PANEL_X + 0.03, PANEL_Z + 0.03)),
                          ((-PANEL_X, -PANEL_Z - 0.03), (PANEL_X, -PANEL_Z)),
                          ((-PANEL_X, PANEL_Z), (PANEL_X, PANEL_Z + 0.03))):
            slab(frame, (x + low[0], HEIGHT - 0.02, z + low[1]), (x + high[0], HEIGHT + 0.01, z + high[1]), 0.003, (0, -1, 0))
    light.open = [1.0] * len(light.positions)
    # The laminar-flow ceiling above the table, slightly brighter than the rest.
    flow = Part("flow", (244, 246, 246), 0.0, 0.5, 0.05)
    slab(flow, (-1.1, HEIGHT - 0.05, -1.3), (1.1, HEIGHT + 0.01, 1.3), 0.02, (0, -1, 0))
    for k in range(1, 4):
        surface(seam, (-1.09, HEIGHT - 0.052, -1.3 + 0.65 * k - 0.004), (2.18, 0, 0), (0, 0, 0.008), 1, 1)
    surface(seam, (-0.004, HEIGHT - 0.052, -1.29), (0.008, 0, 0), (0, 0, 2.58), 1, 1)
    return [wall, band, ceiling, skirting, light, frame, seam, flow], [floor], [lit_floor]


def door_parts():
    """A double door of steel in the wall at -x, with round-cornered windows and kick plates."""
    leaf, steel = Part("door", (176, 198, 200), 0.0, 0.4), Part("door_steel", (190, 195, 198), 1.0, 0.35)
    window, dark = Part("window", (58, 84, 92), 0.0, 0.08, 0.35), Part("door_gap", (40, 50, 54), 0.0, 0.6)
    x = -HALF_X
    slab(steel, (x - 0.01, 0.0, -1.02), (x + 0.045, 2.17, -0.94), 0.008, X)
    slab(steel, (x - 0.01, 0.0, 0.94), (x + 0.045, 2.17, 1.02), 0.008, X)
    slab(steel, (x - 0.01, 2.10, -1.02), (x + 0.0445, 2.18, 1.02), 0.008, X)
    surface(dark, (x + 0.010, 0.0, 0.94), (0, 0, -1.88), (0, 2.1, 0), 2, 3)
    for side in (-1, 1):
        z0, z1 = sorted((0.006 * side, 0.935 * side))
        slab(leaf, (x, 0.012, z0), (x + 0.030, 2.095, z1), 0.006, X)
        slab(steel, (x, 0.03, z0 + 0.03), (x + 0.034, 0.34, z1 - 0.03), 0.003, X)
        slab(steel, (x, 1.22, 0.5 * (z0 + z1) - 0.19), (x + 0.036, 1.74, 0.5 * (z0 + z1) + 0.19), 0.01, X)
        slab(window, (x, 1.25, 0.5 * (z0 + z1) - 0.16), (x + 0.038, 1.71, 0.5 * (z0 + z1) + 0.16), 0.01, X)
        slab(steel, (x, 0.98, 0.10 * side - 0.018), (x + 0.075, 1.10, 0.10 * side + 0.018), 0.012, X)
    return [leaf, steel, window, dark]


def wall_things():
    """Cabinets at -z, a light box and a clock over them, gas and power outlets at +z, a rail."""
    cabinet, glass = Part("cabinet", (216, 224, 223), 0.0, 0.4), Part("cabinet_glass", (66, 92, 98), 0.0, 0.08)
    steel, top = Part("steel", (192, 197, 200), 1.0, 0.3), Part("worktop", (176, 182, 184), 0.9, 0.32)
    film, white = Part("film", (226, 240, 248), 0.0, 0.5, 0.75), Part("box", (216, 220, 219), 0.0, 0.4)
    dark, goods = Part("dark", (44, 50, 55), 0.0, 0.5), Part("goods", (104, 146, 166), 0.0, 0.7)
    z = -HALF_Z
    for k in range(6):
        x0 = -2.0 + 0.66 * k
        slab(cabinet, (x0, 0.10, z), (x0 + 0.65, 0.86, z + 0.50), 0.008)
        slab(steel, (x0 + 0.20, 0.70, z + 0.50), (x0 + 0.45, 0.715, z + 0.525), 0.005)
        if k not in (2, 3):
            slab(cabinet, (x0, 1.46, z), (x0 + 0.65, 2.20, z + 0.32), 0.008)
            slab(glass, (x0 + 0.05, 1.51, z + 0.30), (x0 + 0.60, 2.15, z + 0.3225), 0.004)
            slab(steel, (x0 + 0.585, 1.56, z + 0.322), (x0 + 0.60, 1.72, z + 0.338), 0.004)
    slab(dark, (-1.98, 0.0, z), (1.94, 0.10, z + 0.44), 0.004)
    slab(top, (-2.02, 0.86, z), (1.98, 0.90, z + 0.53), 0.008)
    for x0, w, h, d in ((-1.8, 0.30, 0.16, 0.22), (-1.42, 0.22, 0.10, 0.2), (1.2, 0.34, 0.2, 0.24), (1.6, 0.2, 0.13, 0.2)):
        slab(goods, (x0, 0.90, z + 0.10), (x0 + w, 0.90 + h, z + 0.10 + d), 0.008)
    slab(white, (-0.66, 1.46, z), (0.62, 2.04, z + 0.06), 0.012)
    for x0 in (-0.62, 0.00):
        slab(film, (x0, 1.51, z), (x0 + 0.58, 1.99, z + 0.064), 0.004)
    # Clock.
    first = len(white.positions)
    white.rod(0.17, 0.0, 0.04, 32, axis=2, bevel=0.012)
    white.place(0, 1, (0.0, 2.42, z), first)
    hands = len(dark.positions)
    dark.box((-0.006, 0.0, 0.041), (0.006, 0.085, 0.045), 0.001, blocks=False)
    dark.place(-52.0, 2, (0.0, 2.42, z), hands)
    minute = len(dark.positions)
    dark.box((-0.004, 0.0, 0.0415), (0.004, 0.125, 0.046), 0.001, blocks=False)
    dark.place(-264.0, 2, (0.0, 2.42, z), minute)
    for k in range(12):
        tick = len(dark.positions)
        dark.box((-0.004, 0.125, 0.040), (0.004, 0.148, 0.0425), 0.001, blocks=False)
        dark.place(30.0 * k, 2, (0.0, 2.42, z), tick)
    for part in (white, dark):
        part.open += [0.8] * (len(part.positions) - len(part.open))
    # Supply panel behind the patient's head.
    z = HALF_Z
    slab(white, (-1.3, 1.22, z - 0.07), (1.3, 1.46, z), 0.015)
    for k in range(9):
        x0 = -1.15 + 0.28 * k
        part = (steel, dark, white)[k % 3]
        slab(part, (x0 - 0.04, 1.30, z - 0.085), (x0 + 0.04, 1.38, z - 0.06), 0.006)
    slab(steel, (-1.5, 1.085, z - 0.05), (1.5, 1.115, z - 0.03), 0.008)
    # Hand rail and a waste bin at +x.
    x = HALF_X
    slab(steel, (x - 0.06, 0.99, -2.6), (x - 0.035, 1.05, 2.6), 0.01)
    slab(cabinet, (x - 0.55, 0.0, -2.9), (x - 0.03, 0.95, -2.2), 0.02)
    slab(dark, (x - 0.56, 0.93, -2.91), (x - 0.02, 0.97, -2.19), 0.01)
    return [cabinet, glass, steel, top, film, white, dark, goods]


def make():
    shell, floor, lit_floor = wall_parts()
    write("rooms", "room", {"shell": shell, "floor": floor, "lit_floor": lit_floor})
    write("rooms", "built_in", {"doors": door_parts(), "built_in": wall_things()})
