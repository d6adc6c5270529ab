# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cycles that are added to the loads of solids until the last one is steady."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.contact_runs import ramp
from harness.told import Told

from fretfe._typing import Array
from fretfe.backends.protocol import DEFAULTS, RunOptions
from fretfe.case import Solid, parse_case
from fretfe.contact.solve import Repetition
from fretfe.errors import StoppedError
from fretfe.evaluate.cycles import STEADY_CHANGE
from fretfe.fem._compat import MPI
from fretfe.fem.run import solve
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import Mesh
from fretfe.reason import Kind
from fretfe.results.model import Result

STEPS = 8


def rounded(points: Array) -> Array:
    x, y = points.T
    return np.column_stack([x, y + (1 - y) * x**2 / 4])


def mesh() -> Mesh:
    x = np.linspace(-0.6, 0.6, 17)
    pad = blocks.block("pad", x, [0.0, 0.15, 0.5, 1.0], mapping=rounded)
    wide = np.linspace(-1.0, 1.0, 21)
    base = blocks.block("block", wide, [-1.0, -0.5, -0.15, 0.0])
    return extrude(Mesh({"pad": pad, "block": base}), Solid(length=0.7, layers=2))


def run(options: RunOptions = DEFAULTS, cycles: int = 1, **cycle: Any) -> Result:
    """A pad with free ends on a block; P and Q go up and down together."""
    platen = {"type": "platen", "boundary": "pad_top", "control": "force"}
    wave = {"wave": "sine", "period": 1.0, "cycles": cycles, "steps_per_cycle": STEPS}
    press = [*ramp(-6.0), {**wave, "mean": -6.0, "amplitude": -3.0}]
    shear = [{"hold": True, "until": 1}, {**wave, "amplitude": 1.4}]
    data = {
        "geometry": {"file": "none.msh"},
        "model": {"degree": 1},
        "bodies": {name: {"young": 1000.0, "poisson": 0.3} for name in ("pad", "block")},
        "contacts": {"main": {"surface1": "pad_bottom", "surface2": "block_top", "friction": 0.5}},
        "loads": {
            "press": {**platen, "direction": "y", "history": press},
            "shear": {**platen, "direction": "x", "history": shear},
        },
        "supports": {"base": {"boundary": "block_bottom", "fix": ["x", "y", "z"]}},
        "cycle": cycle,
        "output": {"fields": "none"},
    }
    return solve(MPI.COMM_WORLD, parse_case(data), options, load=mesh)


def tractions(result: Result) -> Array:
    (contact,) = result.solution.contacts
    return np.asarray(contact.mean_traction)[result.solution.ends]


def iterations(result: Result) -> int:
    """Of the last cycle."""
    return int(result.solution.iterations[-STEPS:].sum())


def test_cycles_are_added_until_one_is_steady() -> None:
    told = Told()
    result = run(RunOptions(observer=told))
    (contact,) = result.contacts
    assert result.failure is None and result.loads.cycle is not None
    first, last = result.loads.cycle
    assert (last - first, last) == (STEPS, len(result.loads.times) - 1)
    added = last // STEPS - 1
    assert (
        f"the loads of the case have 1 cycle. {added} cycles like the last one were added, because "
        "the shear still changed from cycle to cycle. The results are those of cycle "
        f"{added + 1} of {added + 1}, from t = {added + 1} to {added + 2} s; it changes shear by "
        f"{contact.cycle_change:.2g} of friction's bound"
    ) in result.notes
    # A line for each cycle before the last one, but for those behind an extrapolation of slip.
    lines = [text for text in told.announced if text.startswith("not steady")]
    changes = [float(text.split("by ")[1].split(" of")[0]) for text in lines]
    assert len(lines) == added - (added + 1) // 3 and added > 4
    assert changes == sorted(changes, reverse=True)
    assert contact.steady and contact.cycle_change < STEADY_CHANGE <= changes[-1]
    (history,) = result.solution.contacts
    found, weights = tractions(result), history.surface.weights
    pressure = (found[first : last + 1, :, 0] @ weights).max()
    change = np.linalg.norm((found[last] - found[first])[:, 1:], axis=1)
    assert contact.cycle_change == pytest.approx(change @ weights / (0.5 * pressure))
    # What is left of the change of friction work is in its bar.
    left = abs(contact.dissipation - contact.dissipation / (1 + contact.dissipation_change))
    assert 0 < left < contact.dissipation_spread - left
    # One node by far more than the contact on average, and not at that the number is taken.
    assert change.max() > 3 * contact.cycle_change * 0.5 * found[last, :, 0].mean()
    kinds = {each.kind for each in contact.warnings}
    assert Kind.UNSTEADY not in kinds
    # The pad touches as far as both bodies end, where no group could go on.
    assert Kind.SURFACE_BORDER not in kinds


def test_added_cycles_are_those_that_could_have_been_written() -> None:
    added, written = run(more=3), run(cycles=4, more=0)
    np.testing.assert_allclose(added.loads.times, written.loads.times, rtol=1e-14)
    np.testing.assert_allclose(added.loads.values, written.loads.values, atol=1e-12)
    expected = tractions(written)
    np.testing.assert_allclose(tractions(added), expected, atol=1e-9 * np.abs(expected).max())
    assert added.loads.cycle == written.loads.cycle
    (one,), (other,) = added.contacts, written.contacts
    assert one.cycle_change == pytest.approx(other.cycle_change, rel=1e-6)
    # Three are not enough, which is told as it is of any history.
    assert not one.steady
    unlike = [pair for pair in zip(one.warnings, other.warnings, strict=True) if len({*pair}) > 1]
    # How more are added is told as the case has them.
    assert [each.kind for pair in unlike for each in pair] == [Kind.UNSTEADY] * 2
    assert "have 1 cycle. 3 cycles like the last one were added" in "".join(added.notes)
    assert "added" not in "".join(written.notes)


@pytest.mark.parametrize("cycle", [{"more": 0}, {"until_steady": False}])
def test_exactly_the_written_cycles(cycle: dict[str, Any]) -> None:
    result = run(**cycle)
    assert len(result.loads.times) == 3 + STEPS
    assert Kind.UNSTEADY in {each.kind for each in result.warnings}


@pytest.mark.parametrize(("done", "evaluated"), [(2, 2), (3, 2), (4, 4)])
def test_a_history_stopped_in_an_added_cycle_is_evaluated(done: int, evaluated: int) -> None:
    """The last whole cycle is, if slip was not extrapolated before it: that is the third one."""
    steps = 2 + done * STEPS + 3
    result = run(RunOptions(observer=Told(steps)))
    assert isinstance(result.failure, StoppedError)
    assert len(result.loads.times) == steps + 1
    assert result.loads.cycle == (2 + (evaluated - 1) * STEPS, 2 + evaluated * STEPS)
    told = f"those of cycle {evaluated} of {done + 3 / STEPS:.3g}, from t = {evaluated} to "
    assert told in "".join(result.notes)
    assert result.contacts[0].cycle_change > STEADY_CHANGE


def test_extrapolated_slip_leads_to_the_same_steady_cycle() -> None:
    """Far more cycles without it end where a few with it do, which without it are far from that."""
    quick, slow = run(), run(cycles=80, more=0)
    count = quick.loads.cycle[1] // STEPS if quick.loads.cycle else 0
    end = tractions(slow)[-1]
    off = [
        np.abs((state - end)[:, 1:]).max() / (0.5 * end[:, 0].max())
        for state in (tractions(quick)[-1], tractions(slow)[2 + count * STEPS])
    ]
    assert off[0] < 0.02 and off[0] < 0.4 * off[1]


def test_starts_from_the_cycle_before_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """But the number of iterations: states are solved to the same accuracy."""
    quick = run(cycles=5, more=0)
    monkeypatch.setattr(Repetition, "like_next", lambda *_: None)
    plain = run(cycles=5, more=0)
    expected = tractions(plain)
    np.testing.assert_allclose(tractions(quick), expected, atol=1e-9 * np.abs(expected).max())
    assert iterations(quick) < 0.75 * iterations(plain)
