# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts as joints: loops of driven boundaries, and what slip adds to them."""

from __future__ import annotations

import csv
import json
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import HOLD, PAD, pad, press, wave
from typer.testing import CliRunner

import fretfe
from fretfe.analytic.profiles import FlatRounded, composite_modulus
from fretfe.case import parse_case
from fretfe.cli.app import app
from fretfe.errors import OutputError
from fretfe.exchange.joint import Loop, joint_loops
from fretfe.results.model import Result
from fretfe.results.writer import write_results


@cache
def solved(
    amplitude: float, thickness: float = 1.0, pulsing: bool = False, flat: float = 0.0
) -> Result:
    shear = {**PAD["loads"]["shear"], "history": [HOLD, wave(amplitude, cycles=2, steps=40)]}
    loads: dict[str, Any] = {"press": press(), "shear": shear}
    if pulsing:
        turn = {"ramp": -500.0, "until": 2.5, "steps": 20}
        back = {"ramp": -600.0, "until": 3.0, "steps": 20}
        held = {"hold": True, "until": 2.0}
        loads["press"] = {**press(), "history": [*press()["history"], held, turn, back]}
    tables = {"loads": loads, "model": {"thickness": thickness}}
    if flat:
        parameters = {"flat_half_width": flat, "radius": 20.0}
        tables["geometry"] = {"template": "flat_rounded", "parameters": parameters}
    return fretfe.run(parse_case(pad(**tables)), backend="halfplane")


def loop(result: Result) -> Loop:
    (found,) = joint_loops(result)
    return found


def test_half_planes_have_no_displacement_of_their_own() -> None:
    found = loop(solved(160.0))
    assert np.isnan([found.displacement_range, found.stiffness, found.loss_factor]).all()
    assert found.joint_stiffness == pytest.approx(found.force_range / found.slip_range)


def test_slip_does_the_friction_work() -> None:
    found = loop(solved(160.0))
    by_slip = float(np.trapezoid(found.force, found.slip["main"]))
    # Of steps within which the pressure is even, but not the shear.
    assert found.work == pytest.approx(by_slip, rel=0.01)
    assert 0 < found.slip_bar < 0.001 * found.slip_range


def slip_of_half_planes(profile: FlatRounded, amplitude: float) -> float:
    """Range of slip in cycles of ±Q, P = 600, f = .4: 4/(pi E*) ∫ ln(a(P)/a(P - q/f)) dq to Q.

    By Ciavarella and Jäger: what is left to move is what a smaller contact of P - q/f moves.
    """
    a = np.linspace(profile.flat_half_width + 1e-6, 1.0, 20_000)
    shear = np.linspace(0.0, amplitude, 2001)
    half_width = np.interp(600.0 - shear / 0.4, profile.load(a), a)
    whole = float(np.trapezoid(np.log(half_width[0] / half_width), shear))
    return 4 * whole / (np.pi * profile.e_star)


@pytest.mark.parametrize("share", [0.1, 1 / 3, 0.8])
@pytest.mark.parametrize("flat", [0.0, 0.5])
def test_bars_hold_the_slip_in_closed_form(flat: float, share: float) -> None:
    found = loop(solved(240.0 * share, flat=flat))
    profile = FlatRounded(flat, 20.0 if flat else 50.0, composite_modulus(210e3, 0.3, 210e3, 0.3))
    error = abs(found.slip_range - slip_of_half_planes(profile, 240.0 * share))
    assert error < found.slip_bar < 0.004 * found.slip_range


def test_smaller_loops_slip_less() -> None:
    less, more = loop(solved(80.0)), loop(solved(160.0))
    assert more.force_range == pytest.approx(320.0, rel=1e-9)
    assert less.joint_stiffness > 2.2 * more.joint_stiffness


def test_an_edge_that_moves_is_no_slip() -> None:
    """P and Q grow together, Q by less than f P: nothing slips, though nodes touch and part."""
    press_on = [{"ramp": -400.0, "until": 1.0, "steps": 4}]
    turns = [{"ramp": -800.0, "until": 1.5, "steps": 8}, {"ramp": -400.0, "until": 2.0, "steps": 8}]
    shear = [
        HOLD,
        {"ramp": 60.0, "until": 1.5, "steps": 8},
        {"ramp": 0.0, "until": 2.0, "steps": 8},
    ]
    loads = {
        "press": {**PAD["loads"]["press"], "history": [*press_on, *turns]},
        "shear": {**PAD["loads"]["shear"], "history": shear},
    }
    case = parse_case(pad(loads=loads, cycle={"start": 1.0, "end": 2.0}))
    for each in joint_loops(fretfe.run(case, backend="halfplane")):
        assert each.slip_range == 0


def test_masing() -> None:
    """Each branch of the loop is first loading, twice as large."""
    first = loop(solved(80.0))
    large = loop(solved(160.0))
    # Slip at the reversal of a cycle of ±Q is that of first loading to Q.
    path = solved(160.0).solution
    states = np.flatnonzero((path.times > 1.0) & (path.times <= 1.25))
    contact = path.contacts[0]
    units = contact.full_stick.fields[int(contact.full_stick.area[states[-1]])][:, 1]
    units = units[:, path.drivers.index("shear")]
    slip = contact.slip[states][:, :, 0] - contact.slip[states[0] - 1][:, 0]
    moved = slip @ (contact.surface.weights * units)
    force = path.driver_values[states, path.drivers.index("shear")]
    for found, load in ((first, 80.0), (large, 160.0)):
        expected = 2 * load**2 * np.interp(load, force, moved / force**2)
        assert found.slip_range == pytest.approx(expected, rel=0.01)


def test_the_thickness_counts() -> None:
    # Q and P are those of the whole thickness: of half of it per length.
    found = loop(solved(160.0, thickness=2.0))
    assert found.force_range == pytest.approx(320.0, rel=1e-9)
    by_slip = float(np.trapezoid(found.force, found.slip["main"]))
    assert found.work == pytest.approx(by_slip, rel=0.01)


def test_two_loads_have_a_loop_each_and_no_loss_factor() -> None:
    found = {each.driver: each for each in joint_loops(solved(80.0, pulsing=True))}
    assert set(found) == {"shear", "normal"}
    assert all(np.isnan(each.loss_factor) for each in found.values())


def test_the_command_prints_and_writes(tmp_path: Path) -> None:
    write_results(tmp_path, solved(160.0))
    run = partial(CliRunner().invoke, app)
    text = run(["joint", str(tmp_path), "--csv", str(tmp_path / "loops.csv")]).output
    assert "secant stiffness" in text and "by slip in main" in text
    with (tmp_path / "loops.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["force"]) for row in rows] == loop(solved(160.0)).force.tolist()
    (found,) = json.loads(run(["joint", str(tmp_path), "--json"]).output)
    assert found["joint_stiffness"] == pytest.approx(loop(solved(160.0)).joint_stiffness, rel=1e-9)
    assert found["loss_factor"] is None


def test_a_run_without_a_cycle_is_refused() -> None:
    shear = {**PAD["loads"]["shear"], "history": [HOLD, {"ramp": 60.0, "until": 2.0, "steps": 2}]}
    case = parse_case(pad(loads={**PAD["loads"], "shear": shear}))
    with pytest.raises(OutputError, match="expected an evaluated cycle, found none"):
        joint_loops(fretfe.run(case, backend="halfplane"))
