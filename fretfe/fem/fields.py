# SPDX-License-Identifier: LGPL-3.0-or-later
"""Displacement and stress fields for ParaView. Collective."""

from __future__ import annotations

from pathlib import Path

from dolfinx import fem
from dolfinx.io import VTKFile

from fretfe._typing import Array
from fretfe.fem.model import Model


def write_fields(
    model: Model,
    fields: list[dict[str, fem.Function]],
    times: Array,
    directory: Path,
) -> None:
    """Write one time series per body: `<body>.pvd`, displacement and stress.

    Both fields are written as discontinuous polynomials of the displacement's degree, which
    holds them exactly; nothing is smoothed between elements.

    Args:
        model: the solved model.
        fields: displacement by body, for each time.
        times: (n,) times of the fields.
        directory: existing folder.
    """
    for name, body in model.bodies.items():
        with VTKFile(body.elastic.comm, directory / f"{name}.pvd", "w") as file:
            for displacements, time in zip(fields, times, strict=True):
                functions = body.elastic.discontinuous_fields(displacements[name])
                file.write_function(functions, float(time))
