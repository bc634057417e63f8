# SPDX-License-Identifier: Apache-2.0
"""Writes binary glTF 2.0. The same nodes always give the same bytes."""
import copy
import json
import struct
from pathlib import Path

ASSETS = Path(__file__).resolve().parent.parent


def welded(part):
    """The part without duplicate vertices and without triangles of zero area."""
    ids, known = [], {}
    out = copy.copy(part)
    out.positions, out.normals, out.uvs, out.open, out.indices = [], [], [], [], []
    for i, p in enumerate(part.positions):
        p = tuple(round(x, 6) + 0.0 for x in p)
        n = tuple(round(x, 4) + 0.0 for x in part.normals[i])
        uv = part.uvs[i]
        light = int(round(255 * max(0.0, min(1.0, part.open[i])))) if part.open else 255
        key = (p, n, uv if part.name.startswith("screen:") else 0, light)
        if key not in known:
            known[key] = len(out.positions)
            out.positions.append(p)
            out.normals.append(n)
            out.uvs.append(uv)
            out.open.append(light)
        ids.append(known[key])
    for k in range(0, len(part.indices), 3):
        a, b, c = (ids[i] for i in part.indices[k:k + 3])
        if len({out.positions[a], out.positions[b], out.positions[c]}) == 3:
            out.indices += [a, b, c]
    return out


class Writer:
    def __init__(self):
        self.blob, self.views, self.accessors, self.materials = bytearray(), [], [], []

    def add(self, data, target, kind, component, count, bounds=None):
        self.blob.extend(b"\0" * (-len(self.blob) % 4))
        self.views.append({"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(data), "target": target})
        self.blob.extend(data)
        accessor = {"bufferView": len(self.views) - 1, "componentType": component, "count": count, "type": kind}
        if component == 5121:
            accessor["normalized"] = True
        if bounds:
            accessor["min"], accessor["max"] = bounds
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def material(self, part):
        material = {"name": part.name, "pbrMetallicRoughness": {
            "baseColorFactor": part.colour, "metallicFactor": part.metallic, "roughnessFactor": part.roughness}}
        if part.emission:
            material["emissiveFactor"] = [round(min(1.0, part.emission * c), 5) for c in part.colour[:3]]
        self.materials.append(material)
        return len(self.materials) - 1

    def primitive(self, part):
        part = welded(part)
        positions = part.positions
        packed = [struct.unpack("<3f", struct.pack("<3f", *p)) for p in positions]
        bounds = ([min(v[i] for v in packed) for i in range(3)], [max(v[i] for v in packed) for i in range(3)])
        count = len(positions)

        def floats(rows, n):
            return b"".join(struct.pack(f"<{n}f", *(round(x, 5) for x in row)) for row in rows)
        attributes = {"POSITION": self.add(b"".join(struct.pack("<3f", *p) for p in positions), 34962, "VEC3", 5126,
                                           count, bounds),
                      "NORMAL": self.add(floats(part.normals, 3), 34962, "VEC3", 5126, count)}
        if part.name.startswith("screen:"):
            attributes["TEXCOORD_0"] = self.add(floats(part.uvs, 2), 34962, "VEC2", 5126, count)
        if min(part.open) < 253:
            attributes["COLOR_0"] = self.add(b"".join(bytes((x, x, x, 255)) for x in part.open), 34962, "VEC4", 5121,
                                             count)
        index = self.add(struct.pack(f"<{len(part.indices)}H", *part.indices), 34963, "SCALAR", 5123,
                         len(part.indices))
        return {"attributes": attributes, "indices": index, "material": self.material(part), "mode": 4}


def write(folder, name, nodes):
    """nodes: {node name: [Part]}, one mesh each, all children of the scene."""
    writer = Writer()
    meshes = [{"name": node, "primitives": [writer.primitive(p) for p in parts if p.indices]}
              for node, parts in nodes.items()]
    writer.blob.extend(b"\0" * (-len(writer.blob) % 4))
    document = {"asset": {"version": "2.0", "generator": "stylet assets/generate"}, "scene": 0,
                "scenes": [{"nodes": list(range(len(meshes)))}],
                "nodes": [{"name": m["name"], "mesh": i} for i, m in enumerate(meshes)], "meshes": meshes,
                "materials": writer.materials, "accessors": writer.accessors, "bufferViews": writer.views,
                "buffers": [{"byteLength": len(writer.blob)}]}
    text = json.dumps(document, separators=(",", ":"), sort_keys=True).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(writer.blob)
    path = ASSETS / folder / f"{name}.glb"
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, total, len(text), 0x4E4F534A) + text +
                     struct.pack("<II", len(writer.blob), 0x004E4942) + bytes(writer.blob))
    vertices = sum(len(p.positions) for parts in nodes.values() for p in parts)
    triangles = sum(len(p.indices) // 3 for parts in nodes.values() for p in parts)
    print(f"{folder}/{name}.glb: {total} bytes, {vertices} vertices, {triangles} triangles")
