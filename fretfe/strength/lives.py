# SPDX-License-Identifier: LGPL-3.0-or-later
"""Laboratory tests from a file: lives, run-outs and edge factors, or loads that they come from."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.analytic.profiles import FlatRounded, Hertz
from fretfe.case import Body, Units, isotropic, load_case
from fretfe.case.materials import with_constants
from fretfe.errors import CaseError
from fretfe.evaluate.limits import DOUBTED
from fretfe.idealise.bodies import Block, geometry_obstacles, read_block
from fretfe.materials.moduli import contact_modulus
from fretfe.mesh.templates import check_parameters, find_template
from fretfe.strength.columns import FACTORS, LOAD_COLUMNS, Columns, read_columns_of_tests
from fretfe.strength.loads import PadEdge, PadLoads, edge_of

# Lines of a file that a note lists.
MOST_LINES = 8


@dataclass(frozen=True)
class StrengthTests:
    """Tests, n of them; factors in the units that are given.

    Attributes:
        path: of the file.
        units: of lengths and stresses.
        k_n, k_t_range: (n,) K_N and ΔK_T at the edge where the specimen failed or could have.
        life: (n,) cycles to failure, or to the end of the test.
        runout: (n,) whether the test ended without failure.
        friction: (n,) coefficient.
        young, poisson: (n,) of the specimen.
        lines: (n,) of the file.
        outside: n reasons why edge factors do not describe a test; empty where they do, and where
            the file has the factors.
        notes: what was found or assumed, in words.
    """

    path: Path
    units: Units
    k_n: Array
    k_t_range: Array
    life: Array
    runout: Bools
    friction: Array
    young: Array
    poisson: Array
    lines: Sequence[int]
    outside: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def inside(self) -> Bools:
        """(n,) tests that edge factors describe."""
        return np.array([not reason for reason in self.outside])


def read_tests(path: Path, units: Units) -> StrengthTests:
    """Read tests.

    Args:
        path: CSV file with a header whose names have their units in brackets.
        units: of the results that the tests are compared with.

    Raises:
        CaseError: file, line and column of what is not as expected.
    """
    columns = read_columns_of_tests(path, units)
    count = len(columns.table.lines)
    outside: tuple[str, ...] = ("",) * count
    notes: tuple[str, ...] = ()
    if columns.kind == LOAD_COLUMNS:
        pads = list(_pads(columns, units))
        edges = [edge_of(_loads(columns, row, pad)) for row, pad in enumerate(pads)]
        k_n, k_t_range = np.array([(each.k_n, each.k_t_range) for each in edges]).T
        young, poisson = np.array([(each.young, each.poisson) for each in pads]).T
        outside = tuple(each.outside for each in edges)
        notes = tuple(_notes(columns, edges))
    else:
        k_n, k_t_range = _factors(columns)
        young, poisson = columns.values["young"], columns.values["poisson"]
    return StrengthTests(
        path=path, units=units, k_n=k_n, k_t_range=k_t_range, life=columns.values["life"],
        runout=columns.runout, friction=columns.values["friction"], young=young, poisson=poisson,
        lines=columns.table.lines, outside=outside, notes=notes,
    )  # fmt: skip


def _factors(columns: Columns) -> tuple[Array, Array]:
    values = columns.values
    if columns.kind == FACTORS:
        return values["k_n"], values["dk_t"]
    stress, root = values["stress"], np.sqrt(values["length"])
    return values["k_n_ratio"] * stress / root, values["dk_t_ratio"] * stress * root


@dataclass(frozen=True)
class _Pad:
    """Pad and specimen of a test, of one material."""

    block: Block
    young: float
    poisson: float


def _pads(columns: Columns, units: Units) -> Iterator[_Pad]:
    """Those of each row: of its case, or as columns have them."""
    if "case" in columns.texts:
        folder = columns.table.path.parent
        yield from _by_text(columns, "case", lambda name: _of_case(folder / name, units))
        return
    sizes = (_column(columns, *each) for each in (
        ("radius", math.nan), ("flat_half_width", 0.0), ("height", math.inf)
    ))  # fmt: skip
    wide = (math.inf, math.inf)
    for body, radius, flat, height in zip(_materials(columns, units), *sizes, strict=True):
        e_star = contact_modulus(body, body, "strain")
        profile = FlatRounded(flat, radius, e_star) if flat else Hertz(radius, e_star)
        block = Block(profile, math.inf, (math.inf, height), wide, math.inf)
        yield _Pad(block, body.young, body.poisson)


def _column(columns: Columns, name: str, default: float) -> list[float]:
    """Numbers of a column, or one in place of them if the file does not have it."""
    if name in columns.values:
        return [float(each) for each in columns.values[name]]
    return [default] * len(columns.table.lines)


def _by_text(columns: Columns, name: str, make: Callable[[str], Any]) -> list[Any]:
    """Something made of each cell of a column, once of equal ones.

    Raises:
        CaseError: with the place of the cell of which nothing can be made.
    """
    found: dict[str, Any] = {}
    for row, text in enumerate(columns.texts[name]):
        if text not in found:
            try:
                found[text] = make(text)
            except CaseError as error:
                raise CaseError(f"{columns.place(row, name)}: {error}") from None
    return [found[text] for text in columns.texts[name]]


def _materials(columns: Columns, units: Units) -> list[Body]:
    """Of each row."""
    if "material" in columns.texts:
        path = columns.table.path
        return _by_text(columns, "material", lambda name: _of_material(name, units, path))
    constants = zip(columns.values["young"], columns.values["poisson"], strict=True)
    return [Body(young=young, poisson=poisson) for young, poisson in constants]


def _of_material(name: str, units: Units, path: Path) -> Body:
    """A material by its name, in some units."""
    tables = {"units": units.model_dump(), "bodies": {"specimen": {"material": name}}}
    found = with_constants(tables, path)[0]["bodies"]["specimen"]
    if "young" not in found:
        raise CaseError(f"expected a material with young and poisson, found {name!r}")
    return Body(young=found["young"], poisson=found["poisson"])


def _of_case(path: Path, units: Units) -> _Pad:
    """Geometry and material of a case; its loads do not count."""
    case = load_case(path)
    bodies = [isotropic(each) for each in case.bodies.values()]
    problems = list(geometry_obstacles(case))
    if case.units != units:
        problems.append("units: expected those of the results")
    if len({each and (each.young, each.poisson) for each in bodies}) > 1 or bodies[0] is None:
        problems.append("bodies: expected the same isotropic material of both")
    if problems:
        raise CaseError(f"{path}: {problems[0]}")
    assert case.geometry.template is not None and bodies[0] is not None
    template = find_template(case.geometry.template, length=case.units.length)
    values = check_parameters(template, case.geometry.parameters)
    block = read_block(case.geometry.template, values, case)
    return _Pad(block, bodies[0].young, bodies[0].poisson)


def _loads(columns: Columns, row: int, pad: _Pad) -> PadLoads:
    """The test of a row, if its numbers can be in the units that they are said to be in."""
    values = {name: float(each[row]) for name, each in columns.values.items()}
    normal, shear = (values[name] / values.get("thickness", 1.0) for name in ("p", "q"))
    test = PadLoads(
        block=pad.block,
        normal_force=normal,
        shear=shear,
        bulk=cmath.rect(values["bulk"], -math.radians(values.get("phase", 0.0))),
        friction=values["friction"],
        yield_stress=values.get("yield", math.inf),
    )
    mean = normal / (2 * test.half_width) / pad.block.profile.e_star
    if not DOUBTED[0] <= mean <= DOUBTED[1]:
        raise CaseError(
            f"{columns.place(row, 'p')}: expected P, radius and Young's modulus with a mean "
            f"pressure of {DOUBTED[0]:g} to {DOUBTED[1]:g} E*, found {mean:.2g} E*: check units"
        )
    if shear == 0 and values["bulk"] == 0:
        columns.table.complain(row, columns.headers["q"], "a number > 0, or a bulk stress")
    return test


def _notes(columns: Columns, edges: Sequence[PadEdge]) -> Iterator[str]:
    """Facts of all tests, and what was not looked at."""
    k_n, k_t = np.max([each.size_errors for each in edges], axis=0)
    if k_n > 0:
        yield f"as specimens are finite, K_N of tests is up to {k_n:.1%} off, ΔK_T {k_t:.1%}"
    lines = [line for line, each in zip(columns.table.lines, edges, strict=True) if each.reverses]
    if lines:
        yield f"the bulk stress reverses the slip of one edge in line {_listed(lines)}"
    if "yield" not in columns.values:
        yield "without a column 'yield' it is not known whether tests stay elastic"
    if columns.unread:
        yield f"columns that are not read: {', '.join(columns.unread)}"


def _listed(lines: Sequence[int]) -> str:
    shown = ", ".join(map(str, lines[:MOST_LINES]))
    return shown if len(lines) <= MOST_LINES else f"{shown} and {len(lines) - MOST_LINES} more"
