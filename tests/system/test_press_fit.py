# SPDX-License-Identifier: LGPL-3.0-or-later
"""Half a ring on half a shaft: the contact goes on at both ends, and has no edges."""

from __future__ import annotations

import numpy as np
import pytest
from cases import blocks, sectors

import fretfe
from fretfe.case import parse_case
from fretfe.mesh.make import write_mesh
from fretfe.mesh.mesh import Mesh
from fretfe.reason import Kind
from fretfe.report.page.html import draw_plots
from fretfe.report.page.tables import edge_answers, station_table
from fretfe.report.pictures.looks import plan_pictures

BORE, SEAT, RIM = 5.0, 10.0, 15.0
YOUNG, POISSON, OVERLAP = 210e3, 0.3, 0.005


def lame_pressure() -> float:
    """Pressure of the fit: a shaft with a free bore in a ring held at its rim, in plane strain.

    By u_r = A r + B/r and sigma_r = E/(1 + nu) (A/(1 - 2 nu) - B/r^2) in both.
    """
    narrow = 1 - 2 * POISSON
    shaft = narrow * SEAT**2 / (SEAT**2 - BORE**2) * (1 + BORE**2 / (SEAT**2 * narrow))
    ring = ((RIM / SEAT) ** 2 - 1) / (1 / narrow + (RIM / SEAT) ** 2)
    return YOUNG * OVERLAP / ((1 + POISSON) * SEAT * (shaft + ring))


@pytest.fixture(scope="module")
def fit(tmp_path_factory: pytest.TempPathFactory) -> fretfe.Result:
    folder = tmp_path_factory.mktemp("fit")
    angles, wave = np.linspace(0, 180, 25), {"wave": "sine", "amplitude": 1.0, "period": 1.0}
    bodies = [
        blocks.block(name, np.linspace(*radii, 4), angles, order=2, mapping=sectors.polar)
        for name, radii in (("shaft", (BORE, SEAT)), ("ring", (SEAT, RIM)))
    ]
    write_mesh(Mesh({each.name: each for each in bodies}), folder / "fit.msh")
    steel = {"young": YOUNG, "poisson": POISSON, "density": 2e-3}
    surfaces = {"surface1": "ring_left", "surface2": "shaft_right", "friction": 0.2}
    cuts = {
        f"{name}_{side}": {"boundary": f"{name}_{side}", "fix": ["y"]}
        for name in ("shaft", "ring")
        for side in ("bottom", "top")
    }
    push = [{"hold": True, "until": 1.0}, {**wave, "cycles": 2, "steps_per_cycle": 4}]
    case = parse_case(
        {
            "geometry": {"file": str(folder / "fit.msh")},
            "bodies": {"shaft": steel, "ring": steel},
            "contacts": {"seat": surfaces},
            "supports": {"rim": {"boundary": "ring_right", "fix": ["x", "y"]}, **cuts},
            "loads": {
                "fit": {
                    "type": "interference",
                    "contact": "seat",
                    "history": [{"ramp": OVERLAP, "until": 1.0, "steps": 1}],
                },
                "push": {"type": "acceleration", "direction": "x", "history": push},
            },
        }
    )
    return fretfe.run(case, output=folder / "results")


def test_it_has_the_pressure_of_lame_and_no_edges(fit: fretfe.Result) -> None:
    (contact,) = fit.contacts
    assert contact.largest_pressure[1] == pytest.approx(lame_pressure(), rel=2e-3)
    assert contact.normal_force[1] == pytest.approx(lame_pressure() * np.pi * SEAT, rel=2e-3)
    assert contact.edges == ()
    assert [each.lack.kind for each in contact.stations] == [Kind.NO_EDGE] * 2
    assert np.isnan(contact.half_width).all()
    assert contact.dissipation == 0.0 == contact.dissipation_spread  # all of it sticks
    assert contact.warnings == () and fit.faults == ()


def test_its_report_speaks_of_no_edges(fit: fretfe.Result) -> None:
    found = fit.headline.sentences
    assert found.worst.startswith("seat: no edge factors, as both bodies go on behind both ends")
    assert found.agreement == "" == found.half
    assert station_table(fit) is None and edge_answers(fit) == ()
    assert {each.kind for each in plan_pictures(fit)} == {"bodies", "status"}
    sections = {each.anchor: each for each in draw_plots(fit)}
    assert all(each.missing == () for each in sections.values())
    assert not {"factors", "edges", "local", "cycles"} & set(sections)
    assert len(sections["slip"].plots) == 1
