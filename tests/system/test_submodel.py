# SPDX-License-Identifier: LGPL-3.0-or-later
"""Parts of bodies that a run of the whole drives at their cuts."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.contact_runs import Run, run

from fretfe._typing import Array
from fretfe.backends.protocol import RunOptions
from fretfe.case import parse_case
from fretfe.errors import CaseError
from fretfe.fem._compat import MPI
from fretfe.fem.run import solve
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.results.model import Result

STEEL = {"young": 200e3, "poisson": 0.3}
RADIUS = 40.0
FINE = np.linspace(-0.6, 0.6, 13)
WIDE = np.concatenate([[-3.0, -1.8, -1.0], FINE, [1.0, 1.8, 3.0]])
DEEP = np.array([0.0, 0.12, 0.3, 0.7, 1.5, 3.0])
# Columns and rows that a part keeps.
KEPT, ROWS = slice(2, -2), 4


def pad(points: Array) -> Array:
    x, y = points.T
    return np.stack([x, y + (1 - y / DEEP[-1]) * x**2 / (2 * RADIUS)], axis=1)


def bodies(columns: Array, rows: Array) -> tuple[BodyMesh, BodyMesh]:
    """A cylinder on a block."""
    upper = blocks.block("upper", columns, rows, mapping=pad, order=2)
    return upper, blocks.block("lower", columns, -rows[::-1], order=2)


def parts(columns: Array, rows: Array) -> tuple[BodyMesh, ...]:
    """What a cut leaves of them, with one boundary "cut" of each."""
    found = []
    for body, surface in zip(bodies(columns, rows), ("bottom", "top"), strict=True):
        own = dict(body.boundaries)
        contact = own.pop(f"{body.name}_{surface}")
        around = np.concatenate(list(own.values()))
        boundaries = {f"{body.name}_{surface}": contact, f"{body.name}_cut": around}
        found.append(replace(body, boundaries=boundaries))
    return tuple(found)


def case(loads: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {
        "bodies": {"upper": STEEL, "lower": STEEL},
        "contacts": {
            "main": {"surface1": "upper_bottom", "surface2": "lower_top", "friction": 0.5}
        },
        "loads": loads,
        **more,
    }


BASE = {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}}


def whole_loads(force: float = 900.0) -> dict[str, Any]:
    platen = {"type": "platen", "boundary": "upper_top", "control": "force"}
    press = [{"ramp": -force, "until": 1.0, "steps": 2}]
    values = [force * part for part in (0.2, -0.2, 0.1)]
    shear = [{"hold": True, "until": 1.0}, {"times": [2, 3, 4], "values": values}]
    return {
        "press": {**platen, "direction": "y", "history": press},
        "shear": {**platen, "direction": "x", "history": shear},
    }


@pytest.fixture(scope="module")
def whole() -> Run:
    """Pressed, then sheared to and fro."""
    return run(case(whole_loads(), supports=BASE), *bodies(WIDE, DEEP))


def nodes(found: Run, step: int, body: str) -> tuple[Array, Array]:
    """(n, 2) places and displacements of a body."""
    field = found.fields(step)[body]
    places = found.model.bodies[body].elastic.space.tabulate_dof_coordinates()[:, :2]
    return places, field.x.array.reshape(-1, 2)


def write_csv(found: Run, path: Path, body: str, unit: float = 1.0) -> None:
    """A table with displacements in a unit."""
    rows = []
    for step, loads in enumerate(found.results):
        rows += [
            f"{step + 1},{x:.17g},{y:.17g},{u / unit:.17g},{v / unit:.17g}\n"
            for (x, y), (u, v) in zip(*nodes(found, step, body), strict=True)
        ]
        assert loads is not None
    path.write_text("# of another program\nstep,x,y,ux,uy\n" + "".join(rows))


def cut(body: str, file: Path, **keys: Any) -> dict[str, Any]:
    count = 5
    history = [{"times": list(range(1, count + 1)), "values": list(range(1, count + 1))}]
    return {
        "type": "field",
        "boundary": f"{body}_cut",
        "file": str(file),
        "history": history,
        **keys,
    }


def test_the_same_mesh_inside_gives_the_same_tractions(whole: Run, tmp_path: Path) -> None:
    for body in ("upper", "lower"):
        write_csv(whole, tmp_path / f"{body}.csv", body)
    loads = {f"{body}_moves": cut(body, tmp_path / f"{body}.csv") for body in ("upper", "lower")}
    part = run(case(loads), *parts(WIDE[KEPT], DEEP[:ROWS]))
    scale = np.abs(whole.tractions).max()
    assert np.abs(whole.tractions[2:, :, 1]).max() > 0.05 * scale
    assert len(part.tractions) == 5
    # nodes of the contact are those of the whole that are inside
    x, inside = (
        np.array([each.coupling.surface.points[:, 0] for each in one.model.reduction.pairs])[0]
        for one in (whole, part)
    )
    chosen = np.searchsorted(np.sort(x), np.sort(inside) - 1e-9)
    expected = whole.tractions[:, np.argsort(x)[chosen]]
    np.testing.assert_allclose(part.tractions[:, np.argsort(inside)], expected, atol=1e-9 * scale)
    for body, sign in (("upper", 1), ("lower", -1)):
        force = part.forces[f"{body}_moves force y"]
        np.testing.assert_allclose(force[1:], -sign * 900.0, rtol=1e-7)
    notes = [note for note in part.model.notes if note.startswith("loads.upper_moves: 5 steps")]
    assert len(notes) == 1 and notes[0].endswith("of the displacements of the cut is left out")


def test_displacements_in_another_unit_than_coordinates(whole: Run, tmp_path: Path) -> None:
    """Metres at millimetres: a note has the factor with which the tractions are those of mm."""
    found = {}
    for name, unit, keys in (
        ("mm", 1.0, {}), ("m", 1e3, {}), ("told", 1e3, {"displacement_factor": 1e3}),
    ):  # fmt: skip
        for body in ("upper", "lower"):
            write_csv(whole, tmp_path / f"{name}-{body}.csv", body, unit)
        loads = {
            body: cut(body, tmp_path / f"{name}-{body}.csv", **keys) for body in ("upper", "lower")
        }
        found[name] = run(case(loads), *parts(WIDE[KEPT], DEEP[:ROWS]))
    scale = np.abs(found["mm"].tractions).max()
    np.testing.assert_allclose(found["told"].tractions, found["mm"].tractions, atol=1e-9 * scale)
    assert np.abs(found["m"].tractions).max() < 0.05 * scale
    doubts = {
        name: [note for note in each.model.notes if "displacement_factor" in note]
        for name, each in found.items()
    }
    assert doubts["mm"] == doubts["told"] == []
    assert len(doubts["m"]) == 2
    for note in doubts["m"]:
        assert re.search(r"of its size at most.* displacement_factor = 1000 would make it", note)


@pytest.mark.mpi
def test_a_bad_table_is_told_on_all_ranks(tmp_path: Path) -> None:
    """Before there is a mesh: there is none."""
    (tmp_path / "run.csv").write_text("x,y,ux,uy\n0,0,0,nan\n")
    data = case({"upper": cut("upper", tmp_path / "run.csv")})
    parsed = parse_case({"geometry": {"file": "none.msh"}, **data})
    with pytest.raises(CaseError, match=r"loads\.upper\.file: .*line 2, column 'uy': expected"):
        solve(MPI.COMM_WORLD, parsed)


def result_of(folder: Path, data: dict[str, Any], meshes: tuple[BodyMesh, ...]) -> Result:
    parsed = parse_case({"geometry": {"file": "none.msh"}, "output": {"fields": "all"}, **data})
    folder.mkdir()
    options = RunOptions(fields=folder / "fields.hdf")
    return solve(MPI.COMM_WORLD, parsed, options, lambda: Mesh({m.name: m for m in meshes}))


def halved(lines: Array) -> Array:
    return np.sort(np.concatenate([lines, (lines[:-1] + lines[1:]) / 2]))


def test_a_results_folder_drives_another_mesh(tmp_path: Path) -> None:
    """Forces follow the whole, as far as six elements over the half-width of its contact allow.

    Both meshes are: with three in the whole the normal force is off by 1.3 %.
    """
    loads = whole_loads(200.0)
    coarse = result_of(
        tmp_path / "whole", case(loads, supports=BASE), bodies(halved(WIDE), halved(DEEP))
    )
    finer = np.linspace(WIDE[KEPT][0], WIDE[KEPT][-1], 31)
    deeper = np.linspace(0.0, DEEP[ROWS], 12)
    moved = {f"{body}_moves": cut(body, tmp_path / "whole") for body in ("upper", "lower")}
    for load in moved.values():
        load["history"] = [{"times": [0.5, 1, 2, 3, 4], "values": [0.5, 1, 2, 3, 4]}]
    part = result_of(tmp_path / "part", case(moved), parts(finer, deeper))
    first, second = coarse.contacts[0], part.contacts[0]
    np.testing.assert_allclose(second.normal_force, first.normal_force, rtol=6e-3)
    np.testing.assert_allclose(second.shear_force, first.shear_force, atol=0.012 * 40.0)
    (note,) = (note for note in part.notes if "loads.upper_moves: the largest force" in note)
    assert re.search(r"is 20\d(\.\d)? N/mm, the largest moment .* N·mm/mm; ", note)


def test_bars_hold_what_slip_does_to_a_near_cut(tmp_path: Path) -> None:
    """At 1.5 half-widths, with the same elements in the whole, so that nothing else differs.

    Under 0.6 of the largest shear the displacements of the cut know that two fifths of the contact
    have slipped, and full stick does not.
    """
    loads = whole_loads(450.0)
    wave = {"wave": "sine", "amplitude": 135.0, "period": 1, "cycles": 2, "steps_per_cycle": 8}
    loads["shear"]["history"] = [{"hold": True, "until": 1.0}, wave]
    columns, rows = halved(WIDE), halved(DEEP)
    coarse = result_of(tmp_path / "whole", case(loads, supports=BASE), bodies(columns, rows))
    kept, deep = columns[np.abs(columns) <= 1.0], rows[rows <= 1.0]
    moved = {f"{body}_moves": cut(body, tmp_path / "whole") for body in ("upper", "lower")}
    steps = coarse.loads.times[1:].tolist()
    for load in moved.values():
        load["history"] = [{"times": steps, "values": steps}]
    cycle = {"start": 2.0, "end": 3.0}
    part = result_of(tmp_path / "part", case(moved, cycle=cycle), parts(kept, deep))
    for first, second in zip(coarse.contacts[0].stations, part.contacts[0].stations, strict=True):
        off = second.k_range - first.k_range
        # the same elements: K_N differs by rounding in the file, which is in single precision
        assert second.decisive_k_n[0] == pytest.approx(first.decisive_k_n[0], rel=1e-4)
        own = second.k_range_parts.discretisation**2 - first.k_range_parts.discretisation**2
        assert 0.005 * first.k_range < abs(off) < own**0.5 < 3 * abs(off)
        assert second.k_range_spread > own**0.5


HOT = {**STEEL, "expansion": 1.2e-5, "reference_temperature": 20.0}
CORNERS = [(x, y) for x in (-10.0, 10.0) for y in (-10.0, 10.0)]


def temperature(x: Array, y: Array, step: int) -> Array:
    """(n,) at a step, linear in the place; it turns from one to the other."""
    return np.asarray(20 + 4 * step * y + (step - 2) * 3 * x + 10 * step)


def write_temperatures(path: Path) -> None:
    x, y = np.array(CORNERS).T
    rows = [
        f"{step},{a},{b},{value:.17g}"
        for step in range(1, 6)
        for a, b, value in zip(x, y, temperature(x, y, step), strict=True)
    ]
    path.write_text("\n".join(["step,x,y,T", *rows]) + "\n")


def heated_case(loads: dict[str, Any], **more: Any) -> dict[str, Any]:
    data = case(loads, **more)
    return {**data, "bodies": {"upper": HOT, "lower": {**HOT, "expansion": 1.7e-5}}}


def test_temperatures_of_another_run_drive_the_whole_and_a_part(tmp_path: Path) -> None:
    """The same as loads of points, and a part with its cut and its temperatures as the whole."""
    write_temperatures(tmp_path / "heat.csv")
    steps = [{"times": list(range(1, 6)), "values": list(range(1, 6))}]
    heat = {"type": "temperature_field", "file": str(tmp_path / "heat.csv"), "history": steps}
    mechanical = whole_loads()
    mechanical["press"]["history"][0]["steps"] = 1
    mechanical["shear"]["history"][1] = {"times": [2, 3, 4, 5], "values": [100, -100, 50, 0]}
    whole = run(heated_case({**mechanical, "heat": heat}, supports=BASE), *bodies(WIDE, DEEP))
    # Two fields of points whose sum is that of the file.
    given = {}
    x, y = np.array(CORNERS).T
    warmer = 20 + temperature(x, y, 2) - temperature(x, y, 1)
    for name, own, amount in (
        ("one", temperature(x, y, 1), [1.0] * 5),
        ("two", warmer, [0, 1, 2, 3, 4]),
    ):
        given[name] = {
            "type": "temperature",
            "points": CORNERS,
            "values": own.tolist(),
            "history": [{"times": list(range(1, 6)), "values": amount}],
        }
    same = run(heated_case({**mechanical, **given}, supports=BASE), *bodies(WIDE, DEEP))
    scale = np.abs(whole.tractions).max()
    np.testing.assert_allclose(whole.tractions, same.tractions, atol=1e-9 * scale)
    (note,) = (note for note in whole.model.notes if note.startswith("loads.heat"))
    assert "5 steps of the run, up to 5, as 2 shapes" in note
    for body in ("upper", "lower"):
        write_csv(whole, tmp_path / f"{body}.csv", body)
    loads = {f"{body}_moves": cut(body, tmp_path / f"{body}.csv") for body in ("upper", "lower")}
    part = run(heated_case({**loads, "heat": heat}), *parts(WIDE[KEPT], DEEP[:ROWS]))
    x, inside = (
        np.array([each.coupling.surface.points[:, 0] for each in one.model.reduction.pairs])[0]
        for one in (whole, part)
    )
    chosen = np.searchsorted(np.sort(x), np.sort(inside) - 1e-9)
    expected = whole.tractions[:, np.argsort(x)[chosen]]
    np.testing.assert_allclose(part.tractions[:, np.argsort(inside)], expected, atol=1e-9 * scale)
    cold = run(heated_case(loads), *parts(WIDE[KEPT], DEEP[:ROWS]))
    assert np.abs(cold.tractions - part.tractions).max() > 0.01 * scale
