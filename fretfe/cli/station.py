# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe station`; the first process works."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretfe.cli.options import Results, examples
from fretfe.environment import rank_from_environment

if TYPE_CHECKING:
    from rich.table import Table

    from fretfe.case import Units
    from fretfe.station import StationModel

EXAMPLES = examples(
    "fretfe station sphere main --station 12 -o sphere_12",
    "fretfe station dovetail left:2 --station 20 -o left_20",
)


def station(
    directory: Results,
    contact: Annotated[
        str,
        typer.Argument(
            metavar="CONTACT[:FRONT]",
            help="Contact, and number of its front from 1.",
            show_default=False,
        ),
    ],
    number: Annotated[
        int, typer.Option("--station", help="Number of the station along the front, from 0.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the results.")],
) -> None:
    """Show the plane problem of a station of solids.

    It has the edge factors of the station; its slip zones and tractions stand beside those of the
    nodes around the station.
    """
    if rank_from_environment() > 0:
        return
    from rich.console import Console

    from fretfe.api import load_result, run_station
    from fretfe.report.texts import with_error

    result = load_result(directory)
    name, front = _front(contact)
    model = run_station(result, name, number, front, output)
    console = Console()
    console.print(_table(result.case.units, model))
    units = result.case.units
    console.print(
        f"K_N {with_error(model.k_n, model.k_n_spread)}, ΔK "
        f"{with_error(model.k_range, model.k_range_spread)}\n"
        f"Plane problem: half-width {model.half_width:.4g}, gap as |x|^{model.power:.3g}; largest "
        f"slip {model.slip:.3g} {units.length}, friction work {model.work:.3g} "
        f"{units.force}·{units.length}/{units.length} in the cycle\nFiles in {output}",
        highlight=False,
        soft_wrap=True,
    )


def _front(text: str) -> tuple[str, int]:
    """The name of a contact and the number of its front."""
    name, _, number = text.rpartition(":")
    return (name, int(number)) if name and number.isdigit() else (text, 1)


def _table(units: Units, model: StationModel) -> Table:
    from fretfe.report.page.listings import plain_table
    from fretfe.report.texts import number, with_error

    title = (
        f"Slip zones at station {model.station} of {model.front} of contact {model.contact}, "
        f"lengths in {units.length}"
    )
    table = plain_table(title, ("half cycle", "by nodes", "predicted", "plane problem"), text=1)
    for zone in model.zones:
        table.add_row(
            f"{zone.start:g} to {zone.end:g}",
            with_error(zone.solid, zone.solid_spread),
            number(zone.predicted, 3),
            with_error(zone.plane, zone.plane_spread),
        )
    return table
