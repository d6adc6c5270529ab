# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables of the bodies of a run, with the orientation of crystals, and of the pairs they make."""

from __future__ import annotations

import numpy as np
from rich.table import Table

from fretfe._typing import Array
from fretfe.case import AnyBody, isotropic
from fretfe.case.bodies import Crystal
from fretfe.idealise.bodies import ROUND_OFF, dissimilarity
from fretfe.materials.moduli import contact_modulus
from fretfe.report.texts import MISSING, number, plain_table
from fretfe.results.model import Result

# Components of a direction below this part of the largest one are round-off.
NOTHING = 1e-9
AXES = ("along x", "along y", "along z")


def body_table(run: Result) -> Table:
    """One row per body: its constants and, of crystals, what lies along the axes of the model."""
    title, bodies = f"Bodies: elastic constants in {run.case.units.stress}", run.case.bodies
    turned = any(not isotropic(each) for each in bodies.values())
    headers = ("body", "material", "constants", *(AXES if turned else ()))
    table = plain_table(title, headers, text=len(headers))
    for name, body in bodies.items():
        table.add_row(name, *_constants(body), *(_directions(body) if turned else ()))
    return table


def _constants(body: AnyBody) -> tuple[str, str]:
    """Kind of a body, and its constants, as text."""
    if known := isotropic(body):
        return "isotropic", _named(("E", "ν"), (known.young, known.poisson))
    assert isinstance(body, Crystal)
    elastic = body.elastic
    if elastic.cubic is not None:
        return "cubic crystal", _named(("c11", "c12", "c44"), elastic.cubic)
    if elastic.orthotropic is not None:
        each = elastic.orthotropic
        names = ("E1", "E2", "E3", "ν12", "ν13", "ν23", "G12", "G13", "G23")
        return "orthotropic", _named(names, (*each.young, *each.poisson, *each.shear))
    return "anisotropic", "21 stiffnesses, as in the case below"


def _named(names: tuple[str, ...], values: tuple[float, ...]) -> str:
    return ", ".join(f"{each} = {number(value)}" for each, value in zip(names, values, strict=True))


def _directions(body: AnyBody) -> tuple[str, ...]:
    """Directions in a crystal that lie along x, y and z, the largest component of each 1."""
    if not isinstance(body, Crystal) or isotropic(body):
        return (MISSING,) * len(AXES)
    return tuple(_direction(each) for each in body.orientation.axes.T)


def _direction(components: Array) -> str:
    scaled = components / np.abs(components).max()
    shown = np.where(np.abs(scaled) > NOTHING, scaled, 0.0)
    return f"[{' '.join(number(each, 3) for each in shown.tolist())}]"


def pair_table(run: Result) -> Table:
    """One row per contact of the case: friction, E* and Dundurs' β."""
    title = f"Pairs: E* in {run.case.units.stress}"
    table = plain_table(title, ("contact", "bodies", "f", "E*", "β"), text=2)
    histories = {each.pair: each for each in run.solution.contacts}
    for name, history in histories.items():
        pair = run.case.bodies[history.body1], run.case.bodies[history.body2]
        where = run.case.model.plane, history.surface.mean_normal
        beta = dissimilarity(*pair, *where)
        unsigned = "" if all(isotropic(each) for each in pair) else "±"
        table.add_row(
            name,
            f"{history.body1} on {history.body2}",
            number(history.friction.largest),
            number(contact_modulus(*pair, *where)),
            unsigned + number(beta, 3) if abs(beta) > ROUND_OFF else "0",
        )
    return table
