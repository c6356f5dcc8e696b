# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of solids in each format that is read, and damage to them."""
from __future__ import annotations

import random
import re
import struct

CORNERS = [[(i >> k) & 1 for k in range(3)] for i in range(8)]
SIDES = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))
HUGE = (2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**64 - 1, 10**9, 10**12, 65536, -1, 0)
WORDS = ("nan", "inf", "-inf", "1e400", "1e308", "1e-320", "-0", "0x10", "+", "1,5", "1/2/3", "//", "#", '"', "g", "f", "v", "facet", "endsolid", "list")
WEDGES = ((0, 1, 3, 4, 5, 7), (0, 3, 2, 4, 7, 6))  # the same cube


def stl(corners, sides, skip=()):
    """A text STL of convex sides, in the unit of the corners."""
    lines = ["solid body"]
    for number, side in enumerate(sides):
        for k in range(1, len(side) - 1):
            if number not in skip:
                lines += ["facet normal 0 0 0", "outer loop",
                          *("vertex {:.17g} {:.17g} {:.17g}".format(*corners[i]) for i in (side[0], side[k], side[k + 1])), "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid body", ""])


def _lines(*parts):
    return ("\n".join(parts) + "\n").encode()


def _points(prefix=""):
    return [prefix + " ".join(str(5 * value) for value in corner) for corner in CORNERS]


def _polygons(prefix="4 ", first=0):
    return [prefix + " ".join(str(i + first) for i in side) for side in SIDES]


def _binary_stl():
    triangles = [(side[0], side[k], side[k + 1]) for side in SIDES for k in (1, 2)]
    facets = (struct.pack("<12fH", 0, 0, 0, *(5 * value for i in triangle for value in CORNERS[i]), 0) for triangle in triangles)
    return b" " * 80 + struct.pack("<I", len(triangles)) + b"".join(facets)


def _ply(form):
    head = _lines("ply", f"format {form} 1.0", "element vertex 8", *(f"property double {axis}" for axis in "xyz"), "element face 6",
                  "property list uchar int vertex_indices", "end_header")
    if form == "ascii":
        return head + _lines(*_points(), *_polygons())
    order = "<" if form == "binary_little_endian" else ">"
    return (head + b"".join(struct.pack(order + "3d", *(5 * value for value in corner)) for corner in CORNERS)
            + b"".join(struct.pack(order + "B4i", 4, *side) for side in SIDES))


def _gmsh(version):
    head = ["$MeshFormat", f"{version} 0 8", "$EndMeshFormat", "$PhysicalNames", "3", '2 1 "base"', '2 2 "tip"', '3 7 "all"', "$EndPhysicalNames"]
    tags = range(10, 90, 10)
    triangles = ((10, 20, 40), (10, 40, 30), (50, 60, 80), (50, 80, 70))
    volumes = [" ".join(str(tags[i]) for i in wedge) for wedge in WEDGES]
    if version == "2.2":
        surface = [f"{i + 1} 2 2 {1 + i // 2} {4 + i // 2} " + " ".join(map(str, triangle)) for i, triangle in enumerate(triangles)]
        return _lines(*head, "$Nodes", "8", *(f"{tag} {point}" for tag, point in zip(tags, _points())), "$EndNodes", "$Elements", "7", *surface,
                      "5 15 2 0 1 10", *(f"{6 + i} 6 2 7 1 {volume}" for i, volume in enumerate(volumes)), "$EndElements")
    surface = [f"{i + 1} " + " ".join(map(str, triangle)) for i, triangle in enumerate(triangles)]
    return _lines(*head, "$Entities", "0 0 2 1", "4 0 0 0 5 5 0 1 1 0", "5 0 0 5 5 5 5 1 2 0", "1 0 0 0 5 5 5 1 7 0", "$EndEntities", "$Nodes", "1 8 10 80",
                  "3 1 0 8", *map(str, tags), *_points(), "$EndNodes", "$Elements", "3 6 1 6", "2 4 2 2", *surface[:2], "2 5 2 2", *surface[2:], "3 1 6 2",
                  *(f"{5 + i} {volume}" for i, volume in enumerate(volumes)), "$EndElements")


def _vtk(version):
    head = [f"# vtk DataFile Version {version}", "two cells", "ASCII", "DATASET UNSTRUCTURED_GRID", "POINTS 8 double", *_points()]
    wedges = [" ".join(map(str, wedge)) for wedge in WEDGES]
    cells = ["CELLS 2 14", *("6 " + wedge for wedge in wedges)] if version == "3.0" else [
        "CELLS 3 12", "OFFSETS vtktypeint64", "0 6 12", "CONNECTIVITY vtktypeint64", *wedges]
    return _lines(*head, *cells, "CELL_TYPES 2", "13", "13")


def every_format():
    """(extension, content) of a sound file in each, all of a cube of 5 units."""
    return [(".stl", stl([[5 * value for value in corner] for corner in CORNERS], SIDES).encode()), (".stl", _binary_stl()),
            (".obj", _lines(*_points("v "), "g sides", *_polygons("f ", 1)[:4], "g ends", *_polygons("f ", 1)[4:])),
            (".off", _lines("OFF", "8 6 0", *_points(), *_polygons())), *((".ply", _ply(form)) for form in ("ascii", "binary_little_endian", "binary_big_endian")),
            *((".msh", _gmsh(version)) for version in ("2.2", "4.1")), *((".vtk", _vtk(version)) for version in ("3.0", "5.1"))]


def damaged(stream: random.Random, content: bytes) -> bytes:
    """The same cut off, with other bytes, words, counts or lines."""
    kind = stream.choice(("cut", "bytes", "words", "counts", "lines"))
    data = bytearray(content)
    place = lambda: stream.randrange(len(data))  # noqa: E731
    if kind == "cut":
        return content[:place()]
    if kind == "lines":
        lines = content.split(b"\n")
        first, second = (stream.randrange(len(lines)) for _ in range(2))
        change = stream.choice(("swap", "double", "leave out"))
        if change == "swap":
            lines[first], lines[second] = lines[second], lines[first]
        elif change == "double":
            lines.insert(second, lines[first])
        else:
            del lines[first]
        return b"\n".join(lines)
    words = [found.span() for found in re.finditer(rb"[^\s]+", content)]
    numbers = [span for span in words if re.fullmatch(rb"-?\d+", content[slice(*span)])]
    if kind == "words" or (kind == "counts" and numbers and b"\0" not in content):
        start, end = stream.choice(numbers if kind == "counts" else words)
        other = str(stream.choice(HUGE)) if kind == "counts" else stream.choice((*WORDS, content[slice(*stream.choice(words))].decode("latin-1"), ""))
        return content[:start] + other.encode("latin-1") + content[end:]
    if kind == "counts":
        start = place()
        data[start:start + 4] = struct.pack("<I", stream.choice(HUGE) % 2**32)
        return bytes(data[:len(content)])
    for _ in range(stream.randint(1, 3)):
        data[place()] = stream.randrange(256)
    return bytes(data)
