# SPDX-License-Identifier: LGPL-3.0-or-later
"""Half of a symmetric contact: one edge, with the numbers of the whole one by Hertz."""

from __future__ import annotations

import math
import signal
from pathlib import Path

import numpy as np
import pytest
from cases.blocks import graded
from cases.tiny_meshes import Element, Node, TinyMesh

import fretfe
from fretfe.backends.protocol import Observer
from fretfe.bodies import expected
from fretfe.bodies.expected import coarse_contacts, pressure_doubts
from fretfe.case import Case, changed, parse_case
from fretfe.checked import check
from fretfe.errors import StoppedError

RADIUS, YOUNG, POISSON, FORCE = 20.0, 210e3, 0.3, 100.0  # of the whole, per unit thickness
MODULUS = YOUNG / (1 - POISSON**2) / 2
HALF_WIDTH = math.sqrt(4 * FORCE * RADIUS / (math.pi * MODULUS))
K_N = 2 * FORCE / (math.pi * HALF_WIDTH) * math.sqrt(2 / HALF_WIDTH)
SIZE = HALF_WIDTH / 12


def half(side: int) -> TinyMesh:
    """Two bodies on one side of x = 0: a pad above, whose lower face is round, and a block."""
    x = np.append(np.arange(0.0, 1.7 * HALF_WIDTH, SIZE), graded(1.7 * HALF_WIDTH, 3.0, 10, 1.4))
    y = np.append(0.0, graded(SIZE, 3.0, 12, 1.4))
    nodes: list[Node] = []
    elements: list[Element] = []
    for name, up in (("pad", 1), ("block", -1)):
        first, rows = len(nodes) + 1, len(x)
        lift = RADIUS - np.sqrt(RADIUS**2 - x**2) if up > 0 else 0 * x
        for height in y:
            raised = up * height + lift * (1 - height / y[-1])
            nodes += [(side * a, float(b), 0.0) for a, b in zip(x, raised, strict=True)]
        corner = [
            first + row * rows + column for row in range(len(y) - 1) for column in range(rows - 1)
        ]
        turn = slice(None, None, side * up)
        elements += [(3, name, [n, n + 1, n + rows + 1, n + rows][turn]) for n in corner]
        top = first + (len(y) - 1) * rows
        elements += [(1, f"{name}_face", [first + n, first + n + 1]) for n in range(rows - 1)]
        elements += [(1, f"{name}_far", [top + n, top + n + 1]) for n in range(rows - 1)]
        sides = [first + row * rows for row in range(len(y) - 1)]
        elements += [(1, f"{name}_middle", [n, n + rows]) for n in sides]
    return TinyMesh(tuple(nodes), tuple(elements))


def half_case(folder: Path, side: int) -> Case:
    half(side).write(folder / "half.msh")
    body = {"young": YOUNG, "poisson": POISSON}
    middles = {
        f"{name}_middle": {"boundary": f"{name}_middle", "fix": ["x"]} for name in ("pad", "block")
    }
    press = {"type": "platen", "boundary": "pad_far", "direction": "y", "control": "force"}
    surfaces = {"surface1": "pad_face", "surface2": "block_face", "friction": 0.0}
    return parse_case(
        {
            "geometry": {"file": "half.msh"},
            "bodies": {"pad": body, "block": body},
            "contacts": {"main": surfaces},
            "supports": {"base": {"boundary": "block_far", "fix": ["y"]}, **middles},
            "loads": {
                "press": {**press, "history": [{"ramp": -FORCE / 2, "until": 1, "steps": 2}]}
            },
        },
        source=folder / "case.toml",
    )


@pytest.mark.parametrize("side", [1, -1], ids=["right", "left"])
def test_half_a_contact_has_one_edge_and_the_whole_width(tmp_path: Path, side: int) -> None:
    result = fretfe.run(half_case(tmp_path, side))
    (contact,) = result.contacts
    assert contact.normal_force[-1] == pytest.approx(FORCE / 2, rel=1e-9)
    # Bodies 20 half-widths high, linear elements of a/12: K_N 2 to 3 % high.
    assert contact.half_width[-1] == pytest.approx(HALF_WIDTH, rel=0.01)
    image, edge = contact.stations[::side]
    assert edge.front == ("right" if side > 0 else "left")
    assert edge.point[:2] == pytest.approx([side * HALF_WIDTH, 0.0], abs=0.01 * HALF_WIDTH)
    # from the plane of symmetry
    assert edge.position[-1] == pytest.approx(side * HALF_WIDTH, abs=0.01 * HALF_WIDTH)
    assert edge.decisive_k_n[0] == pytest.approx(K_N, rel=0.04)
    assert edge.k_n_moved == pytest.approx(K_N, rel=0.06)
    assert np.isnan(image.k_n).all() and image.lack.whole
    told = " ".join(each.sentence for each in contact.warnings)
    assert told == ""  # the plane of symmetry is no edge that a reader could do anything about
    assert result.faults == ()


def test_nothing_is_foretold_of_a_gap_that_is_lowest_at_an_end(tmp_path: Path) -> None:
    checked = check(half_case(tmp_path, 1))
    assert checked is not None
    assert list(coarse_contacts(checked.case, checked.mesh, checked.history)) == []


class Announced(Observer):
    """Keeps what is announced until the first step, and ends the run there."""

    def __init__(self) -> None:
        self.texts: list[str] = []
        self.stepped = False

    def announce(self, text: str) -> None:
        self.texts.append(text)

    def step(self, number: int, count: int, text: str) -> None:
        self.stepped = True

    def stop(self) -> signal.Signals | None:
        return signal.SIGTERM if self.stepped else None


def test_a_run_foretells_the_whole_contact(tmp_path: Path) -> None:
    ramp = {"ramp": -FORCE / 20, "until": 1.0, "steps": 2}
    observer = Announced()
    with pytest.raises(StoppedError):
        fretfe.run(changed(half_case(tmp_path, 1), {"loads.press.history": [ramp]}),
                   observer=observer)  # fmt: skip
    (warning,) = (each for each in observer.texts if "Warning" in each)
    assert "contact main (right): K_N is likely" in warning
    assert "at P = 5 (half-width 0.04" in warning


def test_the_pressure_of_the_whole_is_doubted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By Hertz of the whole .031 E*; half of the force on all of the surface is .017 E*."""
    monkeypatch.setattr(expected, "DOUBTED", (0.0, 0.025))
    ramp = {"ramp": -0.05 * MODULUS, "until": 1.0, "steps": 1}
    checked = check(changed(half_case(tmp_path, 1), {"loads.press.history": [ramp]}))
    assert checked is not None
    about = checked.case, checked.mesh, checked.history
    assert list(pressure_doubts(*about)) == []
    (doubt,) = pressure_doubts(*about, checked.middles)
    assert "means a pressure of 0.031 E*" in doubt


@pytest.mark.parametrize("side", [1, -1], ids=["right", "left"])
def test_elements_are_counted_over_the_whole_width(tmp_path: Path, side: int) -> None:
    """By Hertz of the whole: a tenth of the force has 0.047 mm, three elements on either side."""
    whole = half_case(tmp_path, side)
    for factor, warned in ((1.0, False), (0.1, True)):
        ramp = {"ramp": -factor * FORCE / 2, "until": 1.0, "steps": 2}
        checked = check(changed(whole, {"loads.press.history": [ramp]}))
        assert checked is not None
        (middle,) = checked.middles.values()
        np.testing.assert_allclose(middle, [0.0, 0.0], atol=1e-9)
        assert any(
            "half model: contact main goes on behind the plane of symmetry at (0, 0)" in note
            for note in checked.notes
        )
        found = list(coarse_contacts(checked.case, checked.mesh, checked.history, checked.middles))
        assert bool(found) == warned
        if warned:
            assert "at P = 5 (half-width 0.04" in found[0]
