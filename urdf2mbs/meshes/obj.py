"""Broken .obj files: their text made readable, or their points and faces alone."""

from __future__ import annotations

import re


def utf8(text: bytes) -> bytes:
    """A text that is not in UTF-8, as comments and names often are, made readable."""
    return text.decode("utf-8", "replace").encode()


def plain(data: bytes) -> bytes:
    """An .obj file's points and faces alone, without faces that name other points."""
    points: list[str] = []
    faces: list[str] = []
    for line in data.decode("utf-8", "replace").replace("\\\n", " ").splitlines():
        match line.split():
            case ["v", *numbers]:
                points.append(f"v {' '.join([*numbers[:3], *'000'][:3])}")
            case ["f", *corners]:
                index = [corner.partition("/")[0] for corner in corners]
                if all(re.fullmatch("-?[0-9]+", i) for i in index):
                    which = [int(i) if int(i) > 0 else len(points) + 1 + int(i) for i in index]
                    faces.append(f"f {' '.join(map(str, which))}" if min(which) > 0 else "")
    count = len(points)
    faces = [f for f in faces if f and all(int(i) <= count for i in f.split()[1:])]
    return "\n".join([*points, *faces, ""]).encode()
