# SPDX-License-Identifier: LGPL-3.0-or-later
"""`fretfe animate` and `fretfe scene`: files of a results folder that are made on request."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from fretfe.errors import CaseError, OutputError
from fretfe.report.pictures.child import draw_in_child
from fretfe.results.reader import read_numbers


def animate(directory: Path, output: Path) -> None:
    """Write the evaluated cycle of a run as an animation.

    Raises:
        CaseError: if the file is not to be a GIF.
        OutputError: if it cannot be made.
    """
    _make("animation", directory, output, ".gif")
    Console().print(f"Wrote {output}", highlight=False, soft_wrap=True)


def export(directory: Path, output: Path) -> None:
    """Write the bodies of a run at its last state as a scene for viewers and web pages.

    Raises:
        CaseError: if the file is not to be in glTF format.
        OutputError: if it cannot be made.
    """
    report = _make("scene", directory, output, ".gltf")
    unit = read_numbers(directory)["units"]["stress"]
    text = f"displacements × {report['scale']:g}, colours 0 to {report['limit']:g} {unit}"
    Console().print(f"Wrote {output}: {text}", highlight=False, soft_wrap=True)


def _make(task: str, directory: Path, output: Path, suffix: str) -> dict[str, float]:
    if output.suffix != suffix:
        raise CaseError(f"--output: expected a name that ends in {suffix}, found {str(output)!r}")
    if not output.parent.is_dir():
        raise OutputError(f"{output}: expected an existing folder, found none: {output.parent}")
    numbers = read_numbers(directory)
    if not numbers["mesh"]:
        backend = numbers["backend"]
        raise OutputError(f"{directory}: expected bodies, found none: the backend was {backend!r}")
    (report,) = draw_in_child(task, directory, [str(output)]).values()
    if "reason" in report:
        raise OutputError(f"{directory}: {report['reason']}")
    return report
