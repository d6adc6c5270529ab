# SPDX-License-Identifier: LGPL-3.0-or-later
"""Commands that make pages, animations and scenes of results; the first process writes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fretfe.cli.options import Results, examples
from fretfe.environment import rank_from_environment

REPORT_EXAMPLES = examples("fretfe report pad")


def report(directory: Results) -> None:
    """Make report.html again from the results in a folder."""
    from fretfe.report.page.html import write_report
    from fretfe.results.reader import read_numbers
    from fretfe.results.run_folder import locked

    if rank_from_environment() > 0:
        return
    read_numbers(directory)
    with locked(directory):
        path = write_report(directory)
    print(f"Report in {path}")


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
    from fretfe.report.pictures.folder import draw_in_child
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
