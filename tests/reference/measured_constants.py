# SPDX-License-Identifier: LGPL-3.0-or-later
"""Print the table of docs/method.md of numbers found by trial that decide about printed numbers.

Each number that a module of fretfe names is halved, then doubled, and three contacts of half-planes
and one of solids are evaluated anew: a cylinder under constant P and one under both P and Q, a flat
and rounded punch on few elements, and a sphere. What changes K_N, a range of K_T or a slip zone by
more than `LEAST_CHANGE` of it, or an error bar by more than `LEAST_CHANGE_OF_BARS`, is printed.

Run it with: cd tests; python -m reference.measured_constants [ROOM ...]
"""

from __future__ import annotations

import ast
import importlib
import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np
from cases.halfplane_problems import LIMIT, LOAD, loop, problem, started

import fretfe
from fretfe.analytic.profiles import FlatRounded
from fretfe.errors import FretfeError
from fretfe.evaluate.contacts import Contact, Station
from fretfe.evaluate.evaluate import evaluate
from fretfe.evaluate.step_ends import at_step_ends
from fretfe.halfplane import solve_half_planes
from fretfe.idealise import HalfPlaneProblem

ROOT = Path(fretfe.__file__).parent
# The rooms whose numbers stand between tractions and what is printed of them.
ROOMS = ("analytic", "contact", "evaluate", "halfplane", "history", "loads", "local")
# Those before the evaluation: with other numbers there the contacts are solved anew.
SOLVING = ("analytic", "contact", "halfplane", "loads")
LEAST_CHANGE = 1e-3
LEAST_CHANGE_OF_BARS = 0.1
# Load steps of a cycle.
STEPS = 40
Value = int | float


@dataclass(frozen=True)
class Constant:
    """A number that a module names.

    Attributes:
        module: in which it stands.
        name: its name there.
        value: its value.
    """

    module: str
    name: str
    value: Value

    def times(self, factor: float) -> Value:
        """A multiple of the value; whole numbers stay whole."""
        if isinstance(self.value, float):
            return self.value * factor
        return max(round(self.value * factor), 1)


def numbers_of(tree: ast.Module) -> Iterator[tuple[str, Value]]:
    """The names in capitals that a module gives plain numbers."""
    for statement in tree.body:
        if not isinstance(statement, ast.Assign):
            continue
        (target,) = statement.targets
        pairs = [(target, statement.value)]
        if isinstance(target, ast.Tuple) and isinstance(statement.value, ast.Tuple):
            pairs = list(zip(target.elts, statement.value.elts, strict=True))
        for name, value in pairs:
            if not (isinstance(name, ast.Name) and name.id.isupper()):
                continue
            try:
                number = ast.literal_eval(value)
            except ValueError:
                continue
            if isinstance(number, int | float) and not isinstance(number, bool):
                yield name.id, number


def constants(room: str) -> Iterator[Constant]:
    """The numbers that the modules of a room name."""
    for path in sorted((ROOT / room).rglob("*.py")):
        module = ".".join(("fretfe", *path.relative_to(ROOT).with_suffix("").parts))
        for name, value in numbers_of(ast.parse(path.read_text("utf-8"))):
            yield Constant(module.removesuffix(".__init__"), name, value)


def holders(constant: Constant) -> list[ModuleType]:
    """All modules that know a constant by its name: its own, and those that import it."""
    own = importlib.import_module(constant.module)
    found = [own]
    for name, module in list(sys.modules.items()):
        if name.startswith("fretfe.") and module is not own and _imports(module, constant):
            found.append(module)
    return found


@cache
def _imports(module: ModuleType, constant: Constant) -> bool:
    path = Path(str(module.__file__))
    tree = ast.parse(path.read_text("utf-8") if path.suffix == ".py" else "")
    return any(
        isinstance(node, ast.ImportFrom)
        and node.module == constant.module
        and any(alias.name == constant.name for alias in node.names)
        for node in ast.walk(tree)
    )


@contextmanager
def replaced(constant: Constant, value: Value) -> Iterator[None]:
    """Give a constant another value wherever it is known."""
    modules = holders(constant)
    for module in modules:
        setattr(module, constant.name, value)
    try:
        yield
    finally:
        for module in modules:
            setattr(module, constant.name, constant.value)


def problems() -> Iterator[tuple[HalfPlaneProblem, int]]:
    """Half-plane problems, and on how many elements each is solved."""
    angles = loop(STEPS, 2)
    swing = started(0.6 * LIMIT * np.sin(angles))
    yield problem(LOAD, swing, cycle=STEPS), 150
    normal = LOAD * (1 + 0.2 * np.sin(angles + 0.6))
    yield (
        problem(np.r_[np.full(len(swing) - len(normal), normal[0]), normal], swing, cycle=STEPS),
        100,
    )
    punch = FlatRounded(radius=50.0, flat_half_width=0.7, e_star=100.0)
    yield problem(LOAD, 0.8 * swing, profile=punch, cycle=STEPS), 60


Solved = Callable[[], Contact]


def solve(given: HalfPlaneProblem, elements: int) -> Solved:
    """Solve a problem; what is returned evaluates it."""
    outcome = solve_half_planes(given, elements)
    assert outcome.failure is None

    def evaluated() -> Contact:
        found = evaluate(outcome.solution, outcome.unit_factors)
        return at_step_ends(outcome.solution, found)[1][0]

    return evaluated


def sphere() -> Contact:
    """A sphere, from exact tractions and slips at nodes."""
    from cases.solid_runs import stationed_sphere

    stationed_sphere.cache_clear()
    return stationed_sphere().contacts[0]


def printed(station: Station) -> Iterator[tuple[float, float]]:
    """What is printed of a station: each number with its error bar."""
    yield station.decisive_k_n
    yield station.k_range, station.k_range_spread
    for zone in station.slip_zones:
        yield zone.length, zone.spread


Answer = list[tuple[float, float]]


def answer(contact: Contact) -> Answer:
    """All numbers of a contact that are printed, each with its bar."""
    return [pair for front in contact.fronts for each in front.stations for pair in printed(each)]


def change(before: float, after: float) -> float:
    """Relative change; infinite where a number is lost, or found."""
    if math.isnan(before) or math.isnan(after):
        return 0.0 if math.isnan(before) and math.isnan(after) else math.inf
    return abs(after - before) / max(abs(before), 1e-300) if after != before else 0.0


def changes(before: Answer, after: Answer) -> tuple[float, float]:
    """The largest change of a number, and of an error bar."""
    if len(before) != len(after):
        return math.inf, math.inf
    pairs = [
        [change(*both) for both in zip(*each, strict=True)]
        for each in zip(before, after, strict=True)
    ]
    return max(row[0] for row in pairs), max(row[1] for row in pairs)


def text(of_number: float, of_bar: float) -> str:
    """A cell of the table."""

    def percent(value: float) -> str:
        return "lost or found" if math.isinf(value) else f"{100 * value:.2g} %"

    return f"{percent(of_number)}; {percent(of_bar)}"


def main(rooms: list[str]) -> None:
    """Print the table."""
    given = list(problems())
    kept = [solve(*each) for each in given]
    known = [answer(each()) for each in [*kept, sphere]]
    print("| number | value | halved: numbers; bars | doubled: numbers; bars |\n|---|---|---|---|")
    count = 0
    for constant in (each for room in rooms for each in constants(room)):
        count += 1
        solving = constant.module.split(".")[1] in SOLVING
        cells, decides = [], False
        for factor in (0.5, 2.0):
            with replaced(constant, constant.times(factor)):
                try:
                    now = [solve(*each) for each in given] if solving else kept
                    found = [answer(each()) for each in [*now, sphere]]
                except (FretfeError, ArithmeticError, AssertionError, ValueError, LookupError):
                    cells.append("fails")
                    decides = True
                    continue
            both = [changes(*each) for each in zip(known, found, strict=True)]
            of_number, of_bar = (max(column) for column in zip(*both, strict=True))
            decides |= of_number > LEAST_CHANGE or of_bar > LEAST_CHANGE_OF_BARS
            cells.append(text(of_number, of_bar))
        if decides:
            place = f"`{constant.module.removeprefix('fretfe.')}.{constant.name}`"
            print(f"| {place} | {constant.value:g} | {' | '.join(cells)} |", flush=True)
    print(f"\n{count} numbers tried")


if __name__ == "__main__":
    main(sys.argv[1:] or list(ROOMS))
