# SPDX-License-Identifier: LGPL-3.0-or-later
"""Displacement and stress fields of a model, written state by state. Collective."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

import numpy as np
from dolfinx import fem

from fretfe._typing import Array
from fretfe.errors import OutputError
from fretfe.fem.model import Model
from fretfe.fem.parallel import on_root
from fretfe.files import disk_reason
from fretfe.results.field_files import FieldWriter

T = TypeVar("T")


class FieldOutput:
    """A file that takes the fields of one state after the other. Collective.

    Displacement and stress are those of each element, polynomials of the displacement's degree;
    nothing is smoothed between elements.

    Args:
        model: the bodies.
        path: file to write.

    Raises:
        OutputError: if the file cannot be written; so do all methods.
    """

    def __init__(self, model: Model, path: Path) -> None:
        self._model = model
        self._path = path
        nodes = self._gather({b: e.elastic.element_nodes() for b, e in model.bodies.items()})
        self._writer = self._try(lambda: FieldWriter(path, nodes))

    def close(self) -> None:
        """Finish the file."""
        if self._writer is not None:
            self._writer.close()

    def add(self, time: float, displacements: Mapping[str, fem.Function]) -> None:
        """Append a state.

        Args:
            time: of the state.
            displacements: of the bodies that this process has a part of.
        """
        bodies = {name: (self._model.bodies[name].elastic, u) for name, u in displacements.items()}
        moved = self._gather({b: e.element_displacements(u) for b, (e, u) in bodies.items()})
        stress = self._gather({b: e.element_stresses(u) for b, (e, u) in bodies.items()})
        fields = {"displacement": list(moved.values()), "stress": list(stress.values())}
        writer = self._writer
        self._try(lambda: writer.add(time, fields) if writer is not None else None)

    def _try(self, work: Callable[[], T]) -> T | None:
        """Do `work` on rank 0."""

        def attempt() -> T:
            try:
                return work()
            except OSError as error:
                raise OutputError(
                    f"{self._path}: the fields cannot be written: {disk_reason(error)}"
                ) from error

        return on_root(self._model.comm, attempt, share=False)

    def _gather(self, parts: Mapping[str, Array]) -> dict[str, Array]:
        """Parts of bodies (m, k, c) put together on rank 0, in the order of the case."""
        own = {}
        for name, part in parts.items():
            comm = self._model.bodies[name].elastic.comm
            gathered = comm.gather(part)
            if gathered is not None:
                own[name] = np.concatenate(gathered)
        whole: dict[str, Array] = {}
        for each in self._model.comm.gather(own) or []:
            whole |= each
        return {name: whole[name] for name in self._model.case.bodies if name in whole}
