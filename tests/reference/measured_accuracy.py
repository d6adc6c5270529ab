# SPDX-License-Identifier: LGPL-3.0-or-later
"""Print the accuracy that docs/method.md and docs/edges.md tell, against closed forms.

Run it with: .venv/bin/PYTHONPATH=tests python -m reference.measured_accuracy
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from cases.edge_contacts import SIDES, fitted
from system import test_b1 as b1
from system import test_cylinders as cylinders
from system import test_dovetail as dovetail
from system import test_punches as punches

from fretfe.analytic.profiles import Hertz, edge_factor_k_n
from fretfe.evaluate.plane.edge_fits import with_gap
from fretfe.surface import mortar


def largest(errors: Iterable[float]) -> float:
    """The error with the largest magnitude, with its sign."""
    return float(max(errors, key=abs))


def edge_factors(run: b1.Run, state: int) -> list[tuple[float, float]]:
    """Relative errors of K_N and K_T at both edges."""
    a = run.reference(state).half_width
    k_n = b1.E_STAR / (2 * b1.RADIUS) * np.sqrt(2 * a)
    k_t = run.summary.shear_force[state] / (np.pi * np.sqrt(2 * a))
    return [
        (edge.k_n[state] / k_n - 1, sign * edge.k_t[state] / k_t - 1)
        for edge, sign in zip(run.summary.stations, (1, -1), strict=True)
    ]


def pressure_error(run: b1.Run, state: int) -> float:
    """Root mean square error of p over the inner 98 % of the contact, relative to the peak."""
    a = run.reference(state).half_width
    x = run.contact.surface.arc - run.summary.centre[state]
    inside = np.abs(x) < 0.98 * a
    exact = b1.HERTZ.pressure(x[inside], a)
    return b1.rms(run.contact.mean_traction[state, inside, 0] - exact) / float(exact.max())


def stick_error(run: b1.Run, state: int) -> float:
    """Error of the stick half-width, relative to the half-width of the contact."""
    reference = run.reference(state)
    zones = [zone for edge in run.summary.stations for zone in edge.slip_zones if zone.end == state]
    expected = float(reference.stick_half_width(run.summary.shear_force[state]))
    return (abs(zones[1].border - zones[0].border) / 2 - expected) / reference.half_width


def errors(run: b1.Run) -> dict[str, float]:
    """Rows of the table: the largest in magnitude at the extremes of the shear force."""
    states = b1.EXTREMES
    factors = [pair for state in states for pair in edge_factors(run, state)]
    widths = [run.summary.half_width[s] / run.reference(s).half_width - 1 for s in states]
    work = run.reference(states[1]).dissipation(abs(float(run.summary.shear_force[states[1]])))
    return {
        "half-width a": largest(widths),
        "K_N": largest(k_n for k_n, _ in factors),
        "K_T": largest(k_t for _, k_t in factors),
        "pressure, rms over p0": largest(pressure_error(run, state) for state in states),
        "shear at first extreme": b1.shear_error(run, states[0]),
        "shear after reversals": largest(b1.shear_error(run, state) for state in states[1:]),
        "stick half-width, over a": largest(stick_error(run, state) for state in states),
        "dissipation in the cycle": run.summary.dissipation / work - 1,
    }


def solver(run: b1.Run) -> str:
    """Iterations and certificate."""
    solution = run.solution
    iterations, certificates = solution.iterations[1:], solution.certificates
    balance = (certificates["force_imbalance"] / certificates["force_scale"].max()).max()
    return (
        f"P = {run.summary.normal_force[b1.PRESS]:.0f}, |Q| ="
        f" {abs(run.summary.shear_force[15]):.0f}, a = {run.summary.half_width[15]:.3f}, centre"
        f" moves by {np.abs(run.summary.centre[[*b1.EXTREMES]]).max():.4f};"
        f" iterations {iterations.mean():.1f}, at most {iterations.max()}, steps cut"
        f" {(solution.parts[1:] > 1).sum()}, slow method {solution.fallbacks.sum()};"
        f" violation {certificates['worst'].max():.0e}, balance {balance:.0e}"
    )


def print_b1(folder: Path) -> None:
    """B1 on all meshes, with friction from the first step, and multipliers on the other side."""
    columns = []
    for name, (degree, h, multipliers) in b1.CASES.items():
        run = b1.run_b1(folder, degree, h, multipliers=multipliers)
        print(f"B1, {name}: {solver(run)}")
        columns.append(errors(run))
        if (degree, h) == (2, 0.02):
            k_n = [edge.k_n[state] for edge in run.summary.stations for state in b1.EXTREMES]
    for quantity in columns[0]:
        cells = [f"{100 * column[quantity]:.2g} %".replace("-", "−") for column in columns]
        print(f"| {quantity} | {' | '.join(cells)} |")
    other = b1.run_b1(folder, 2, 0.02, multipliers="surface2").summary.stations
    changed = [edge.k_n[state] for edge in other for state in b1.EXTREMES]
    print(f"B1, multipliers on the other surface: K_N {largest(np.divide(changed, k_n) - 1):.3%}")
    pressed = b1.run_b1(folder, 2, 0.02, friction_from=0.0)
    shear = max(b1.shear_error(pressed, state) for state in b1.EXTREMES)
    print(f"B1, friction from the first step: shear {shear:.2%}")


def print_cylinders(height: float) -> None:
    """Two cylinders with bodies of a height."""
    references = (cylinders.HALF_WIDTH, cylinders.STICK_HALF_WIDTH, cylinders.K_N, cylinders.K_T)
    contact, summary = cylinders.run(upper_height=height, lower_height=height)
    a, stick, k_n, k_t = np.divide(cylinders.factors(summary), references) - 1
    peak = contact.mean_traction[-1, :, 0].max() / cylinders.PEAK_PRESSURE - 1
    print(
        f"cylinders {height:.0f} mm high: a {a:.2%}, stick half-width {stick:.2%},"
        f" K_N {k_n:.2%}, K_T {k_t:.2%}, peak pressure {peak:.2%}"
    )


def normals_of_body_1(surface1: Any, surface2: Any) -> np.ndarray:
    """In place of `mortar.contact_normals`."""
    opposite = surface1.nearest(surface2.nodes.reshape(-1, 2))[1]
    return -opposite.reshape(surface2.normals.shape)


def with_normals(normals: Callable[..., np.ndarray], run: Callable[[], Any]) -> Any:
    """What a run gives with other contact normals."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mortar, "contact_normals", normals)
        return run()


def print_wrong_normals() -> None:
    """What changes where the normals are those of one body."""
    solution, contacts = dovetail.run_dovetail(0.004)
    changed, spoilt = with_normals(normals_of_body_1, lambda: dovetail.run_dovetail(0.004))
    fields = [run.contacts[1] for run in (solution, changed)]
    for x, edge, other in zip((-2.0, 2.0), contacts[1].stations, spoilt[1].stations, strict=True):
        pressures = [np.interp(x, c.surface.arc, c.mean_traction[-1, :, 0]) for c in fields]
        print(
            f"dovetail, normals of the blade, {edge.front}: pressure at the end of the flat"
            f" {pressures[1] / pressures[0] - 1:.0%}, K_N {other.k_n[-1] / edge.k_n[-1] - 1:.1%},"
            f" ΔK_T {other.k_t_range / edge.k_t_range - 1:.1%}"
        )
    print("cylinders, normals of the upper body, then of the lower:")
    with_normals(normals_of_body_1, lambda: print_cylinders(8.0))
    with_normals(lambda _, surface2: surface2.normals, lambda: print_cylinders(8.0))


def punch(name: str, elements: int) -> punches.Punch:
    """A punch with so many elements over the rounded part, or over half the contact."""
    bodies = dict.fromkeys(punches.BODIES, 60.0)
    size = {"size": 1 / elements}
    if name == "wedge":
        return replace(punches.wedge(), parameters=punches.wedge().parameters | bodies | size)
    if name == "cylinder":
        shape = {"upper_radius": 200.0, "lower_radius": 0.0, "zone": 1.3, "growth": 0.2}
        return punches.Punch(name, bodies | shape | size, Hertz(200.0, punches.E_STAR), 0.0)
    flat = float(name)
    found = punches.flat_rounded(flat)
    edge_size = {"edge_size": (1 - flat) / elements}
    return replace(found, parameters=found.parameters | bodies | edge_size)


def k_n_error(chosen: punches.Punch, degree: int = 2) -> str:
    """Error of K_N and its bar in %, from nodal values; the larger one of both edges."""
    contact = punches.press(chosen, degree)[1]
    exact = float(edge_factor_k_n(chosen.profile, 1.0))
    pressure = contact.traction[-1, :, 0]
    fits = [fitted(contact.surface.arc, pressure, side, solved=True) for side in SIDES]
    found = with_gap(fits, contact, pressure[None])
    pairs = [(abs(float(np.max(fit.k_n)) - exact), float(np.max(fit.spread_k_n))) for fit in found]
    error, bar = (100 * each / exact for each in max(pairs))
    return f"{error:.2f} ± {bar:.2g}" + ("" if error < bar else " OUTSIDE")


def print_meshes() -> None:
    """K_N of punches for many sizes of the elements at the edge."""
    rows = dict.fromkeys(("0.5", "0.8", "0.95", "cylinder"), (12, 25, 50, 100))
    for name, counts in (rows | {"wedge": (6, 8, 12, 16, 24)}).items():
        cells = [k_n_error(punch(name, elements)) for elements in counts]
        print(f"| {name} | {' | '.join(cells)} |")
        print(f"  order 1: {k_n_error(punch(name, counts[-1]), degree=1)}")


if __name__ == "__main__":
    with TemporaryDirectory() as folder:
        print_b1(Path(folder))
    for body_height in (8.0, 12.0, 16.0):
        print_cylinders(body_height)
    print_wrong_normals()
    print_meshes()
