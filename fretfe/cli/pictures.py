# SPDX-License-Identifier: LGPL-3.0-or-later
"""The commands `fretfe animate` and `fretfe scene`: files that are made on request."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fretfe.cli.options import Results, examples

ANIMATE_EXAMPLES = examples("fretfe animate pad -o cycle.gif")
SCENE_EXAMPLES = examples("fretfe scene pad -o pad.gltf")


def animate(
    results: Results,
    output: Annotated[Path, typer.Option("--output", "-o", help="File to write (.gif).")],
) -> None:
    """Draw the evaluated cycle of a run as an animation.

    The run needs the fields of all steps.
    """
    from rich.console import Console

    _make("animation", results, output, ".gif")
    Console().print(f"Wrote {output}", highlight=False, soft_wrap=True)


def scene(
    results: Results,
    output: Annotated[Path, typer.Option("--output", "-o", help="File to write (.gltf).")],
) -> None:
    """Write the bodies and their last stress as a glTF scene."""
    from rich.console import Console

    from fretfe.results.reader import read_numbers

    report = _make("scene", results, output, ".gltf")
    unit = read_numbers(results)["units"]["stress"]
    text = f"displacements × {report['scale']:g}, colours 0 to {report['limit']:g} {unit}"
    Console().print(f"Wrote {output}: {text}", highlight=False, soft_wrap=True)


def _make(task: str, directory: Path, output: Path, suffix: str) -> dict[str, float]:
    from fretfe.errors import CaseError, OutputError
    from fretfe.report.pictures.child import draw_in_child
    from fretfe.results.reader import read_numbers

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
