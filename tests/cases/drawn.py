# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results folders with bodies and fields that no finite elements had to compute."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
from cases.pad_cases import pad, press, shear

from fretfe._typing import Array
from fretfe.backends import find_backend
from fretfe.case import Case, parse_case
from fretfe.mesh.mesh import BodyMesh
from fretfe.results.field_files import FIELDS, FieldWriter
from fretfe.results.writer import write_results

# Places of the six nodes of a triangle in terms of its corners, in VTK's order.
NODES = np.array([[2, 0, 0], [0, 2, 0], [0, 0, 2], [1, 1, 0], [0, 1, 1], [1, 0, 1]]) / 2


def rectangle(low: tuple[float, float], high: tuple[float, float], count: int = 16) -> BodyMesh:
    """2 count² triangles."""
    x, y = np.meshgrid(*(np.linspace(a, b, count + 1) for a, b in zip(low, high, strict=True)))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    first = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    quads = np.stack([first, first + 1, first + count + 2, first + count + 1], axis=1)
    cells = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return BodyMesh("", points, cells, "triangle", 1, {})


BODIES = {"upper": rectangle((-2.0, 0.0), (2.0, 2.0)), "lower": rectangle((-3.0, -2.0), (3.0, 0.0))}


def pad_case(**output: object) -> Case:
    """A cylinder on a block, P = 600 and Q = 60 sin t."""
    loads = {"press": press(steps=2), "shear": shear(steps=4)}
    return parse_case(pad(loads=loads, output=output))


def write_folder(folder: Path, times: Sequence[float]) -> Path:
    """Results of half-planes with bodies, and fields of them at some times."""
    case = pad_case()
    folder.mkdir()
    result = find_backend("halfplane").solve(case)
    write_results(folder, replace(result, backend="fem", bodies=BODIES))
    write_fields(folder / FIELDS, times)
    return folder


def fields(points: Array, time: float) -> tuple[Array, Array]:
    """Displacement (n, 2) and stress (n, 4) of a made-up state: pressed down, σx = 100 + 10 x t."""
    displacement = np.stack([0.001 * time * points[:, 1], -0.002 + 0 * points[:, 1]], axis=1)
    stress = np.zeros((len(points), 4))
    stress[:, 0] = 100 + 10 * points[:, 0] * time
    stress[:, 2] = 0.3 * stress[:, 0]
    return displacement, stress


def write_fields(path: Path, times: Sequence[float]) -> None:
    """Fields of both bodies on triangles of order 2."""
    nodes = {name: NODES @ body.points[body.cells] for name, body in BODIES.items()}
    with closing(FieldWriter(path, nodes)) as writer:
        for time in times:
            pairs = [fields(each.reshape(-1, 2), time) for each in nodes.values()]
            moved, stress = (
                [values.reshape(-1, len(NODES), values.shape[1]) for values in each]
                for each in zip(*pairs, strict=True)
            )
            writer.add(time, {"displacement": moved, "stress": stress})
