# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress around the stations of solids: an extruded pad against half-planes, margins, files."""

from __future__ import annotations

import copy
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cases.pad_cases import cylinder, pad, press, shear
from decision.test_material import write
from reference.elliptical_stress import elliptical_stress
from typer.testing import CliRunner

from fretfe._typing import Array
from fretfe.case import parse_case
from fretfe.cli.app import app
from fretfe.decision.assess import assess
from fretfe.decision.assessment import Criterion
from fretfe.decision.field import EdgeField
from fretfe.decision.station_field import station_fields
from fretfe.decision.stress_histories import edge_histories
from fretfe.errors import OutputError
from fretfe.evaluate.contacts import Station
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.station_stress import (
    STATION_STRESSES,
    read_station_stress,
    write_station_stress,
)
from fretfe.runner import Runner

LENGTH, SIZE = 1.0, 0.05
# R = 50, P = 600 and Q = 60 per length, f = 0.4, steel in plane strain.
E_STAR = 210e3 / (2 * (1 - 0.3**2))
A = np.sqrt(4 * 600 * 50 / (np.pi * E_STAR))
P0 = 2 * 600 / (np.pi * A)
C = A * np.sqrt(1 - 60 / (0.4 * 600))


OUTPUT = {"fields": "none", "stress_depths": [2 * SIZE, 3 * SIZE, 4 * SIZE, 0.23]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A slice of a pad that cannot move along z: eleven elements over the half-width, one in d."""
    loads = copy.deepcopy({"press": press(steps=2), "shear": shear(60, steps=8)})
    for load in loads.values():
        for part in load["history"]:
            part.update({key: part[key] * LENGTH for key in ("ramp", "amplitude") if key in part})
    ends = {
        f"{body}_{end}": {"boundary": f"{body}_{end}", "fix": ["z"]}
        for body in ("upper", "lower")
        for end in ("front", "back")
    }
    tables = pad(
        # The surface that may touch ends nearer to the edge than the stress is asked for.
        geometry={**cylinder(size=SIZE, zone=0.7), "solid": {"length": LENGTH, "layers": 2}},
        loads=loads,
        output=OUTPUT,
        edges={"stations": 8},
    )
    tables["supports"] = {**tables["supports"], **ends}
    folder = tmp_path_factory.mktemp("slice") / "run"
    Runner.find("fem").run(parse_case(tables), folder)
    return folder


@pytest.fixture(scope="module")
def solved(folder: Path) -> Result:
    return load_result(folder)


def swing(result: Result, field: EdgeField, points: Array) -> Array:
    """(M, 6) half the difference between the extremes of Q, which the size of bodies leaves."""
    times = result.solution.times[field.states]
    ends = [int(np.argmin(np.abs(times - time))) for time in (2.25, 2.75)]
    stress = field.stress(points)
    return np.asarray(stress[ends[0]] - stress[ends[1]]) / 2


def exact(station: Station, number: int, points: Array) -> Array:
    """(M, 3) xx, yy, xy of half-planes in the axes of an edge; Q is to +x on body 2."""
    inward = np.sign(station.frame.inward[0])
    q = 0.4 * P0 * inward * (1 if number == 1 else -1)
    x, depth = points[:, 0] - A, -points[:, 1]
    return elliptical_stress(x, depth, A, 0, q) - elliptical_stress(x, depth, C, 0, q * C / A)


def test_an_extruded_pad_is_that_of_half_planes(solved: Result) -> None:
    """From a quarter of an element on: 1 % of p0 by the shear, nothing along the front."""
    rays = np.array([-0.5, 0.0, 0.5])
    directions = np.stack([np.sin(rays), -np.cos(rays)], axis=1)
    points = (directions[:, None] * SIZE * np.array([[0.25], [1.0], [2.5]])).reshape(-1, 2)
    found = list(station_fields(solved, solved.contacts[0]))
    assert len(found) == 16
    for station, fields in found:
        for number, field in enumerate(fields):
            assert isinstance(field, EdgeField)
            own = swing(solved, field, points)
            assert np.abs(own[:, [0, 1, 3]] - exact(station, number, points)).max() < 0.01 * P0
            assert np.abs(own[:, 4:]).max() < 0.01 * P0
            assert own[:, 2] == pytest.approx(0.3 * (own[:, 0] + own[:, 1]), abs=0.01 * P0)
            assert field.smooth.spread < 0.05 * P0 and field.finest == 0
            # Bodies go on beyond it, and cracks of all stations are followed as far.
            assert field.smooth.widest == (field.smooth.deepest, field.smooth.deepest)


def test_fronts_have_margins(solved: Result, tmp_path: Path) -> None:
    found = assess(solved, write(tmp_path))
    assert [(each.edge, each.body) for each in found.edges] == [
        (front, body) for front in ("front 1", "front 2") for body in ("upper", "lower")
    ]
    for edge in found.edges:
        assert not edge.lost and edge.arrest is not None and 0 < edge.bar < 0.1
        for criterion in list(Criterion)[1:]:
            judgement = edge.of(criterion)
            assert 0 <= judgement.station < 8
            assert judgement.low < judgement.margin < judgement.high
        # Half-planes of the same case have 2.88 to 2.9 by the last one.
        assert edge.of(Criterion.FINDLEY).margin == pytest.approx(2.89, rel=0.05)


def test_margins_are_those_of_the_plane(solved: Result, tmp_path: Path) -> None:
    """Within the bars of each other, of criteria that are not worst where the surface ends."""
    loads = {"press": press(steps=2), "shear": shear(60, steps=8)}
    tables = pad(geometry=cylinder(size=SIZE, zone=0.7), loads=loads, output=OUTPUT)
    Runner.find("fem").run(parse_case(tables), tmp_path / "plane")
    material = write(tmp_path)
    plane = assess(load_result(tmp_path / "plane"), material).edges
    for one, other in zip(plane, assess(solved, material).edges, strict=True):
        for criterion in (
            Criterion.ARREST, Criterion.CROSSLAND, Criterion.DANG_VAN, Criterion.FINDLEY
        ):  # fmt: skip
            flat, space = one.of(criterion), other.of(criterion)
            assert flat.low < space.margin < flat.high and space.low < flat.margin < space.high


def test_the_command_and_the_histories(folder: Path, solved: Result, tmp_path: Path) -> None:
    arguments = [
        "assess",
        str(folder),
        "--material",
        str(write(tmp_path)),
        "-o",
        str(tmp_path / "o"),
    ]
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 0 and "of front" in done.stdout
    numbers = json.loads((tmp_path / "o" / "assessment.json").read_text("utf-8"))
    assert numbers["edges"][0]["criteria"]["Findley, point"]["station"] >= 0
    histories = edge_histories(solved, [0.1, 0.25], [0.0, 45.0])
    assert {each.edge for each in histories} == {f"front {n}.{k}" for n in (1, 2) for k in range(8)}
    for each in histories:
        assert each.stress.shape == (9, 3, 6) and each.distances.tolist() == [0.1, 0.1, 0.25]
    tables = CliRunner().invoke(
        app, ["export", str(folder), "-o", str(tmp_path / "t"), "--depth", "0.1"]
    )
    assert tables.exit_code == 0 and (tmp_path / "t" / "edge_histories.csv").is_file()


def test_files_that_are_not_whole(solved: Result, tmp_path: Path) -> None:
    (tmp_path / STATION_STRESSES).write_bytes(b"no file of HDF5")
    with pytest.raises(
        OutputError, match=r"station_stress\.h5: expected the stress at the stations"
    ):
        read_station_stress(tmp_path, "main")
    with pytest.raises(OutputError, match="of other"):
        solved.station_stress("other")


def test_a_contact_without_known_places_has_no_stress(solved: Result, tmp_path: Path) -> None:
    """It is in the file all the same: what is not known has a reason."""
    known = solved.station_stress("main")
    none = replace(
        known, fronts=(), numbers=known.numbers[:0], mouths=known.mouths[:0],
        depths=known.depths[:0], places=known.places[:0], stress=known.stress[:, :0],
    )  # fmt: skip
    write_station_stress(tmp_path / STATION_STRESSES, [none])
    for _, fields in station_fields(replace(solved, directory=tmp_path), solved.contacts[0]):
        assert fields == ("its place is not known in all states of the cycle with contact",) * 2
