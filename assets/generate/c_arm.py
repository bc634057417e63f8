# SPDX-License-Identifier: Apache-2.0
"""Mobile C-arm. Frame: origin at the isocentre, y up, z along the patient toward the head; the stand is at -x. The
source is 0.72 m below the isocentre and the detector 0.38 m above it, 1.10 m apart. Nodes: `stand` (its floor is at y
= -ISOCENTRE_HEIGHT), `carriage` (rotates about x by the angulation), `arc` (after that, rotates about z by the orbital
angle)."""
import math

from geometry import Part, curve, rounded_rectangle
from gltf import write
from shade import shade

ISOCENTRE_HEIGHT = 1.07
RADIUS, FROM_DEG, TO_DEG = 0.845, 83.0, 277.0


def arc():
    white = Part("arc", (222, 226, 226), 0.0, 0.3)
    rail = Part("rail", (150, 156, 160), 0.9, 0.35)
    dark = Part("housing", (58, 64, 70), 0.0, 0.45)
    grid = Part("grid", (26, 28, 31), 0.0, 0.5)
    trim = Part("trim", (40, 132, 148), 0.0, 0.35)

    def frames(radius):
        out = []
        for i in range(33):
            a = math.radians(FROM_DEG + (TO_DEG - FROM_DEG) * i / 32)
            out.append(((radius * math.cos(a), radius * math.sin(a), 0.0), (math.cos(a), math.sin(a), 0.0),
                        (0.0, 0.0, 1.0)))
        # x cross y = (sin, -cos, 0) points against growing angles, so the order is reversed.
        return out[::-1]
    white.sweep(rounded_rectangle(0.075, 0.120, 0.018, 2), frames(RADIUS))
    for side in (-1, 1):
        rail.sweep([(x, y + 0.045 * side, nx, ny) for x, y, nx, ny in rounded_rectangle(0.016, 0.014, 0.004, 1)],
                   frames(RADIUS + 0.042))
    # Detector: a flat panel on a neck.
    white.box((-0.165, 0.392, -0.165), (0.165, 0.462, 0.165), 0.02, 2)
    grid.box((-0.150, 0.380, -0.150), (0.150, 0.394, 0.150), 0.003)
    dark.box((-0.115, 0.460, -0.115), (0.115, 0.500, 0.115), 0.012, 2)
    white.lathe([[(0.085, 0.498), (0.072, 0.56), (0.072, 0.72), (0.085, 0.79)]], 28)
    dark.box((-0.10, 0.775, -0.085), (0.12, 0.900, 0.085), 0.025, 2)
    trim.box((-0.168, 0.424, -0.168), (0.168, 0.430, 0.168), 0.002, blocks=False)
    # Tube: a tank with a collimator that faces up.
    dark.lathe([[(0.0, -0.665), (0.075, -0.665)], [(0.075, -0.665), (0.085, -0.70)], [(0.085, -0.70), (0.085, -0.73)]],
               28)
    dark.lathe([[(0.085, -0.73), (0.085, -0.665), (0.075, -0.655)], [(0.075, -0.655), (0.0, -0.655)]], 28)
    white.box((-0.150, -0.865, -0.120), (0.190, -0.725, 0.120), 0.035, 2)
    trim.box((-0.152, -0.790, -0.122), (0.192, -0.784, 0.122), 0.002, blocks=False)
    cable = Part("cable", (34, 36, 40), 0.0, 0.55)
    cable.tube(0.013, curve([(-0.10, -0.80, 0.06), (-0.30, -0.90, 0.09), (-0.60, -0.76, 0.09), (-0.82, -0.50, 0.085),
                             (-0.96, -0.22, 0.10), (-0.99, -0.10, 0.12)], 4), 7)
    parts = [white, rail, dark, grid, trim, cable]
    shade(parts)
    return parts


def carriage():
    shell = Part("carriage", (214, 219, 220), 0.0, 0.32)
    dark = Part("carriage_seam", (52, 58, 64), 0.0, 0.5)
    shell.box((-1.005, -0.165, -0.095), (-0.900, 0.165, 0.095), 0.03, 2)
    dark.box((-0.915, -0.150, -0.080), (-0.885, 0.150, 0.080), 0.01)
    shell.rod(0.085, -1.16, -0.99, 28, axis=0, bevel=0.012)
    for side in (-1, 1):
        shell.tube(0.011, curve([(-0.99, -0.11, 0.10 * side), (-0.99, -0.11, 0.15 * side), (-0.99, 0.0, 0.165 * side),
                                 (-0.99, 0.11, 0.15 * side), (-0.99, 0.11, 0.10 * side)], 3), 7)
    parts = [shell, dark]
    shade(parts)
    return parts


def stand():
    floor = -ISOCENTRE_HEIGHT
    shell = Part("cabinet", (220, 224, 224), 0.0, 0.33)
    dark = Part("foot", (54, 60, 66), 0.0, 0.5)
    steel = Part("steel", (196, 200, 204), 1.0, 0.25)
    black = Part("tyre", (24, 25, 27), 0.0, 0.7)
    trim = Part("trim", (40, 132, 148), 0.0, 0.35)
    shell.box((-1.72, floor + 0.14, -0.26), (-1.20, floor + 0.80, 0.26), 0.05, 3)
    trim.box((-1.722, floor + 0.60, -0.262), (-1.198, floor + 0.612, 0.262), 0.003, blocks=False)
    shell.box((-1.66, floor + 0.79, -0.20), (-1.36, floor + 0.90, 0.20), 0.03, 2)  # console
    steel.box((-1.44, floor + 0.60, -0.075), (-1.30, -0.10, 0.075), 0.02, 2)
    shell.box((-1.47, -0.125, -0.105), (-1.15, 0.125, 0.105), 0.035, 2)
    dark.box((-1.74, floor + 0.07, -0.28), (-1.15, floor + 0.16, 0.28), 0.02, 2)
    for side in (-1, 1):
        dark.box((-1.30, floor + 0.055, 0.235 * side - 0.04), (-0.55, floor + 0.115, 0.235 * side + 0.04), 0.02, 2)
        for x, r in ((-0.60, 0.05), (-1.60, 0.09)):
            black.rod(r, 0.235 * side - 0.022 + (0.07 * side if r > 0.06 else 0.0),
                      0.235 * side + 0.022 + (0.07 * side if r > 0.06 else 0.0), 20, (x, floor + r, 0.0), 2, 0.006)
    screen = Part("panel", (30, 88, 104), 0.0, 0.25, 0.6)
    screen.box((-1.60, floor + 0.895, -0.13), (-1.44, floor + 0.904, 0.13), 0.002, blocks=False)
    steel.tube(0.014, curve([(-1.71, floor + 0.72, -0.2), (-1.79, floor + 0.80, -0.2), (-1.80, floor + 0.81, 0.0),
                             (-1.79, floor + 0.80, 0.2), (-1.71, floor + 0.72, 0.2)], 5), 10)
    parts = [shell, dark, steel, black, trim, screen]
    shade(parts, floor=floor)
    return parts


def make():
    write("rooms", "c_arm", {"stand": stand(), "carriage": carriage(), "arc": arc()})
