# SPDX-License-Identifier: LGPL-3.0-or-later
"""Arrays of a file of VTK's older format: as long as their heads state.

VTK takes for the rest of an array that ends too soon what is in memory, and says nothing. An array
that is put behind those of the file is found by VTK only where the last of these is whole.
"""

from __future__ import annotations

import contextlib
import mmap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from fretfe.errors import CaseError
from fretfe.results.tables import require

# The array behind all others. It begins without a line's end, or it would still be found behind one
# that lacks the last byte of its numbers.
LAST = "fretfe_last"
TAIL = f"FIELD fretfe 1\n{LAST} 1 1 unsigned_char\n".encode()
TAILS = {b"ascii": TAIL + b"7\n", b"binary": TAIL + b"\7\n"}
# Words of an error of VTK that are told: those before say where in its code it was found.
TOLD = 30


def require_whole(path: Path, data: mmap.mmap) -> None:
    """Check that the arrays of a file have as many values as their heads state.

    Raises:
        CaseError: if one has not, or VTK does not read the file.
        DependencyError: if PyVista is not installed, with which VTK comes.
    """
    for _ in range(2):  # version and title
        data.readline()
    form = data.readline().strip().lower()
    if form not in TAILS:
        raise CaseError(f"{path}: line 3: expected ASCII or BINARY, found {form[:30]!r}")
    if not data[-1:].isspace():
        raise CaseError(
            f"{path}: expected a line's end behind the last array, found the file to end before: "
            "it may be cut off"
        )
    found, told = _read(data[:] + TAILS[form])
    if told or not any(each.HasArray(LAST) for each in found):
        error = f": {told[0]}" if told else ""
        raise CaseError(
            f"{path}: expected arrays with as many values as their heads state, found others, or "
            f"the file to end before{error}"
        )


def _read(content: bytes) -> tuple[list[Any], list[str]]:
    """All groups of arrays that VTK finds in the content of a file, and its errors."""
    require("pyvista")
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.util.vtkConstants import VTK_CHAR
    from vtkmodules.vtkIOLegacy import vtkDataSetReader

    reader: Any = vtkDataSetReader()
    reader.ReadFromInputStringOn()
    reader.SetInputArray(numpy_to_vtk(np.frombuffer(content, np.int8), array_type=VTK_CHAR))
    with errors_of_vtk() as told:
        reader.Update()
    grid = reader.GetOutput()
    groups = (grid.GetPointData(), grid.GetCellData(), grid.GetFieldData()) if grid else ()
    return [*groups], told


@contextlib.contextmanager
def errors_of_vtk() -> Iterator[list[str]]:
    """Errors that VTK tells meanwhile, in one line each: it raises none."""
    from vtkmodules.util.misc import calldata_type
    from vtkmodules.util.vtkConstants import VTK_STRING
    from vtkmodules.vtkCommonCore import vtkOutputWindow

    told: list[str] = []

    @calldata_type(VTK_STRING)
    def note(_window: Any, _event: str, text: str) -> None:
        told.append(" ".join(text.split()[-TOLD:]))

    window: Any = vtkOutputWindow.GetInstance()
    number = window.AddObserver("ErrorEvent", note)
    try:
        yield told
    finally:
        window.RemoveObserver(number)
