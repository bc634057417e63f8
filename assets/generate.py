#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the meshes in rooms/ and instruments/ (binary glTF, metres). Run it from anywhere; same script, same bytes."""
import json
import math
import struct
from pathlib import Path

HERE = Path(__file__).resolve().parent


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(v):
    n = math.sqrt(sum(x * x for x in v)) or 1.0
    return tuple(x / n for x in v)


class Part:
    """Triangles of one material."""

    def __init__(self, name, srgb, metallic, roughness):
        def linear(c):
            return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4
        self.name = name
        self.colour = [round(linear(c / 255.0), 5) for c in srgb] + [1.0]
        self.metallic, self.roughness = metallic, roughness
        self.positions, self.normals, self.indices = [], [], []

    def vertex(self, p, n):
        self.positions.append(p)
        self.normals.append(unit(n))
        return len(self.positions) - 1

    def polygon(self, points):
        """A flat convex polygon, counter-clockwise from outside."""
        n = cross(sub(points[1], points[0]), sub(points[2], points[0]))
        ids = [self.vertex(p, n) for p in points]
        for i in range(1, len(ids) - 1):
            self.indices += [ids[0], ids[i], ids[i + 1]]

    def lathe(self, profile, sides, centre=(0.0, 0.0, 0.0), axis=2):
        """Surface of revolution of [(radius, height)], smooth along runs, creased where a point is repeated."""
        def place(r, h, angle):
            u, v = r * math.cos(angle), r * math.sin(angle)
            p = (u, v, h) if axis == 2 else (v, h, u)
            return tuple(a + b for a, b in zip(p, centre))
        for (r0, h0), (r1, h1) in zip(profile, profile[1:]):
            if (r0, h0) == (r1, h1):
                continue
            rings = []
            for r, h in ((r0, h0), (r1, h1)):
                ring = []
                for i in range(sides):
                    angle = 2 * math.pi * i / sides
                    out = place(h1 - h0, -(r1 - r0), angle)
                    ring.append(self.vertex(place(r, h, angle), sub(out, centre)))
                rings.append(ring)
            for i in range(sides):
                j = (i + 1) % sides
                a, b, c, d = rings[0][i], rings[0][j], rings[1][j], rings[1][i]
                self.indices += [a, b, c, a, c, d]

    def box(self, low, high):
        (x0, y0, z0), (x1, y1, z1) = low, high
        self.polygon([(x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)])
        self.polygon([(x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0)])
        self.polygon([(x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1)])
        self.polygon([(x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)])
        self.polygon([(x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0)])
        self.polygon([(x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)])

    def cushion(self, x, y0, y1, z0, z1, radius, steps=6):
        """A pad with rounded upper and lower edges: a superposition of rounded rectangles from y0 to y1."""
        corner = 4
        rows = []
        for k in range(-steps, steps + 1):
            angle = math.pi / 2 * k / steps
            inset = radius * (1 - math.cos(angle))
            middle, half = 0.5 * (y0 + y1), 0.5 * (y1 - y0) - radius
            y = middle + math.copysign(half, k) * (1 if k else 0) + radius * math.sin(angle)
            rows.append((inset, y, math.cos(angle), math.sin(angle)))
        outline = []
        big = 0.04
        for cx, cz, start in ((x - big, z1 - big, 0), (-x + big, z1 - big, 1), (-x + big, z0 + big, 2),
                              (x - big, z0 + big, 3)):
            for i in range(corner + 1):
                angle = math.pi / 2 * (start + i / corner)
                outline.append((cx, cz, math.cos(angle), math.sin(angle)))
        rings = [[self.vertex((cx + (big - inset) * c, y, cz + (big - inset) * s), (c * out, up, s * out))
                  for cx, cz, c, s in outline] for inset, y, out, up in rows]
        n = len(outline)
        for low, high in zip(rings, rings[1:]):
            for i in range(n):
                j = (i + 1) % n
                self.indices += [low[i], high[i], high[j], low[i], high[j], low[j]]
        for ring, up in ((rings[-1], 1), (rings[0], -1)):
            ids = [self.vertex(self.positions[i], (0, up, 0)) for i in ring]
            for i in range(1, n - 1):
                self.indices += [ids[0], ids[i], ids[i + 1]] if up < 0 else [ids[0], ids[i + 1], ids[i]]


def write_glb(path, nodes):
    """nodes: [(name, [Part])], one mesh each."""
    blob, views, accessors, materials, meshes, scene = bytearray(), [], [], [], [], []

    def add(data, target, kind, component, count, bounds=None):
        while len(blob) % 4:
            blob.append(0)
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(data), "target": target})
        blob.extend(data)
        accessor = {"bufferView": len(views) - 1, "componentType": component, "count": count, "type": kind}
        if bounds:
            accessor["min"], accessor["max"] = bounds
        accessors.append(accessor)
        return len(accessors) - 1

    for name, parts in nodes:
        primitives = []
        for part in parts:
            def floats(list_):
                return b"".join(struct.pack("<3f", *v) for v in list_)
            packed = [struct.unpack("<3f", struct.pack("<3f", *v)) for v in part.positions]
            bounds = ([min(v[i] for v in packed) for i in range(3)], [max(v[i] for v in packed) for i in range(3)])
            position = add(floats(part.positions), 34962, "VEC3", 5126, len(part.positions), bounds)
            normal = add(floats(part.normals), 34962, "VEC3", 5126, len(part.normals))
            index = add(struct.pack(f"<{len(part.indices)}H", *part.indices), 34963, "SCALAR", 5123,
                        len(part.indices))
            materials.append({"name": part.name, "pbrMetallicRoughness": {
                "baseColorFactor": part.colour, "metallicFactor": part.metallic, "roughnessFactor": part.roughness}})
            primitives.append({"attributes": {"POSITION": position, "NORMAL": normal}, "indices": index,
                               "material": len(materials) - 1, "mode": 4})
        meshes.append({"name": name, "primitives": primitives})
        scene.append({"name": name, "mesh": len(meshes) - 1})
    while len(blob) % 4:
        blob.append(0)
    document = {"asset": {"version": "2.0", "generator": "stylet assets/generate.py"}, "scene": 0,
                "scenes": [{"nodes": list(range(len(scene)))}], "nodes": scene, "meshes": meshes,
                "materials": materials, "accessors": accessors, "bufferViews": views,
                "buffers": [{"byteLength": len(blob)}]}
    text = json.dumps(document, separators=(",", ":"), sort_keys=True).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(blob)
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, total, len(text), 0x4E4F534A) + text +
                     struct.pack("<II", len(blob), 0x004E4942) + bytes(blob))
    print(f"{path.relative_to(HERE)}: {total} bytes")


def table():
    """Operating table. Frame: x to the patient's right, y up, z to the head; the pad's top is y = 0, centred under the
    trunk. The pedestal is one unit high (y from -1 to 0) and is scaled to the floor when it is drawn."""
    pad = Part("pad", (38, 44, 50), 0.0, 0.55)
    for z0, z1 in ((-1.08, -0.36), (-0.35, 0.42), (0.43, 0.82)):
        pad.cushion(0.265, -0.065, 0.0, z0, z1, 0.018)
    steel = Part("steel", (196, 200, 202), 0.9, 0.32)
    steel.box((-0.25, -0.085, -1.06), (0.25, -0.067, 0.80))
    for side in (-1, 1):
        x = 0.285 * side
        steel.box((min(x, x + 0.012 * side), -0.098, -0.95), (max(x, x + 0.012 * side), -0.068, 0.70))
        for z in (-0.85, -0.40, 0.05, 0.50):
            low, high = sorted((0.25 * side, x))
            steel.box((low, -0.090, z - 0.012), (high, -0.076, z + 0.012))
    frame = Part("frame", (214, 218, 216), 0.0, 0.4)
    frame.box((-0.15, -0.15, -0.45), (0.15, -0.0855, 0.35))
    top = [pad, steel, frame]

    column = Part("column", (206, 210, 210), 0.0, 0.35)
    column.lathe([(0.0, -0.16), (0.125, -0.16), (0.125, -0.16), (0.125, -0.50), (0.125, -0.50), (0.145, -0.50),
                  (0.145, -0.50), (0.15, -0.94)], 40, axis=1)
    base = Part("base", (70, 78, 82), 0.0, 0.45)
    base.box((-0.27, -0.985, -0.55), (0.27, -0.93, 0.40))
    for x in (-0.21, 0.21):
        for z in (-0.48, 0.33):
            base.lathe([(0.0, -1.0), (0.035, -1.0), (0.035, -1.0), (0.035, -0.985)], 16, (x, 0.0, z), axis=1)
    write_glb(HERE / "rooms" / "table_top.glb", [("top", top)])
    write_glb(HERE / "rooms" / "table_pedestal.glb", [("pedestal", [column, base])])


def needle():
    """17 G puncture needle, 150 mm. Frame: tip at the origin, +z along the shaft toward the hub."""
    radius, length, bevel = 0.00075, 0.150, math.radians(22.0)
    sides = 24
    steel = Part("steel", (208, 212, 216), 1.0, 0.22)
    # A plane cut at the bevel's angle. Its point would lie on the shaft's rim; its first millimetre closes onto the
    # axis, so that the visible point is where the forces have it.
    def cut(angle):
        return (radius - radius * math.cos(angle)) / math.tan(bevel)
    low, high, rim = [], [], []
    for i in range(sides):
        angle = 2 * math.pi * i / sides
        n = (math.cos(angle), math.sin(angle), 0.0)
        x, y = radius * n[0], radius * n[1]
        closing = math.sqrt(min(1.0, cut(angle) / (1.5 * radius)))
        rim.append((x * closing, y * closing, cut(angle)))
        low.append(steel.vertex(rim[-1], n))
        high.append(steel.vertex((x, y, 0.012), n))
    for i in range(sides):
        j = (i + 1) % sides
        steel.indices += [low[i], low[j], high[j], low[i], high[j], high[i]]
    ground = Part("bevel", (232, 234, 236), 1.0, 0.12)
    middle = tuple(sum(p[k] for p in rim) / sides for k in range(3))
    for i in range(sides):
        ground.polygon([middle, rim[(i + 1) % sides], rim[i]])
    steel.lathe([(radius, 0.012), (radius, length - 0.002)], sides)
    # Depth marks every 10 mm, as drawn on puncture needles.
    marks = Part("marks", (34, 36, 40), 0.0, 0.6)
    for k in range(3, 14):
        z = 0.010 * k
        marks.lathe([(radius * 1.04, z - 0.0005), (radius * 1.04, z + 0.0005)], sides)
    hub = Part("hub", (226, 74, 60), 0.0, 0.35)
    hub.lathe([(0.0, length - 0.004), (0.0016, length - 0.004), (0.0016, length - 0.004), (0.0032, length + 0.004),
               (0.0036, length + 0.014), (0.0036, length + 0.014), (0.0056, length + 0.0145),
               (0.0056, length + 0.0145), (0.0056, length + 0.019), (0.0056, length + 0.019),
               (0.0040, length + 0.0195), (0.0040, length + 0.0195), (0.0038, length + 0.030),
               (0.0038, length + 0.030), (0.0, length + 0.030)], 32)
    wings = Part("wings", (236, 236, 232), 0.0, 0.4)
    wings.box((-0.0130, -0.0011, length + 0.0045), (0.0130, 0.0011, length + 0.0125))
    write_glb(HERE / "instruments" / "needle.glb", [("needle", [steel, ground, marks, hub, wings])])


if __name__ == "__main__":
    table()
    needle()
