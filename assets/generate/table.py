# SPDX-License-Identifier: Apache-2.0
"""Operating table for X-ray work: a long top, supported at the foot end only, with space for the C-arm's tube below
it. Frame: x to the patient's right, y up, z to the head. The top of the pad is y = 0, centred under the trunk. The
pedestal is one unit high (y from -1 to 0) and is scaled to the floor when it is drawn."""
import math

from geometry import Part
from gltf import write
from shade import shade

HALF_WIDTH, FOOT, HEAD = 0.265, -1.30, 0.85


def cushion(part, x, y0, y1, z0, z1, radius, corner_radius=0.04, steps=4, corner=4):
    """A pad with round edges: rounded rectangles from y0 to y1."""
    rows = []
    for k in range(-steps, steps + 1):
        angle = math.pi / 2 * k / steps
        half = math.copysign(0.5 * (y1 - y0) - radius, k) if k else 0.0
        rows.append((radius * (1 - math.cos(angle)), 0.5 * (y0 + y1) + half + radius * math.sin(angle),
                     math.cos(angle), math.sin(angle)))
    outline = []
    for cx, cz, start in ((x - corner_radius, z1 - corner_radius, 0), (-x + corner_radius, z1 - corner_radius, 1),
                          (-x + corner_radius, z0 + corner_radius, 2), (x - corner_radius, z0 + corner_radius, 3)):
        for i in range(corner + 1):
            angle = math.pi / 2 * (start + i / corner)
            outline.append((cx, cz, math.cos(angle), math.sin(angle)))
    rings = [[part.vertex((cx + (corner_radius - inset) * c, y, cz + (corner_radius - inset) * s),
                          (c * out, up, s * out)) for cx, cz, c, s in outline] for inset, y, out, up in rows]
    n = len(outline)
    for low, high in zip(rings, rings[1:]):
        for i in range(n):
            j = (i + 1) % n
            part.indices += [low[i], high[i], high[j], low[i], high[j], low[j]]
    for ring, up in ((rings[-1], 1), (rings[0], -1)):
        ids = [part.vertex(part.positions[i], (0, up, 0)) for i in ring]
        for i in range(1, n - 1):
            part.indices += [ids[0], ids[i], ids[i + 1]] if up < 0 else [ids[0], ids[i + 1], ids[i]]
    part.blockers.append(((-x, y0, z0), (x, y1, z1)))


def make():
    pad = Part("pad", (36, 41, 48), 0.0, 0.5)
    for z0, z1 in ((FOOT, -0.47), (-0.46, 0.44), (0.45, HEAD)):
        cushion(pad, HALF_WIDTH, -0.062, 0.0, z0, z1, 0.018)
    board = Part("board", (52, 55, 58), 0.0, 0.28)  # carbon: X-rays pass
    board.box((-0.262, -0.086, FOOT - 0.01), (0.262, -0.064, HEAD), 0.006)
    steel = Part("steel", (198, 202, 205), 1.0, 0.28)
    for side in (-1, 1):
        low, high = sorted((0.280 * side, 0.292 * side))
        steel.box((low, -0.092, -1.20), (high, -0.064, 0.70), 0.002)
        for z in (-1.10, -0.70, -0.30, 0.10, 0.55):
            low, high = sorted((0.255 * side, 0.286 * side))
            steel.box((low, -0.084, z - 0.012), (high, -0.072, z + 0.012), 0.002, blocks=False)
    frame = Part("frame", (216, 220, 219), 0.0, 0.38)
    frame.box((-0.20, -0.165, -1.27), (0.20, -0.087, -0.58), 0.012, 2)
    frame.box((-0.225, -0.108, -1.15), (0.225, -0.087, -0.20), 0.006)
    top = [pad, board, steel, frame]
    shade(top)

    column = Part("column", (208, 212, 212), 0.0, 0.33)
    column.box((-0.165, -0.52, -1.13), (0.165, -0.15, -0.77), 0.03, 3)
    bellows = Part("bellows", (44, 48, 52), 0.0, 0.6)
    for k in range(9):
        bellows.box((-0.150, -0.90 + 0.044 * k, -1.115), (0.150, -0.90 + 0.044 * k + 0.036, -0.785), 0.014, 2,
                    blocks=k == 4)
    base = Part("base", (198, 203, 203), 0.0, 0.36)
    base.box((-0.28, -0.975, -1.36), (0.28, -0.895, -0.52), 0.025, 3)
    feet = Part("feet", (40, 44, 47), 0.0, 0.55)
    feet.box((-0.265, -1.0, -1.345), (0.265, -0.972, -0.535), 0.006)
    pedestal = [column, bellows, base, feet]
    shade(pedestal, floor=-1.0)
    write("rooms", "table_top", {"top": top})
    write("rooms", "table_pedestal", {"pedestal": pedestal})
