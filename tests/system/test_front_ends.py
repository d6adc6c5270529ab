# SPDX-License-Identifier: LGPL-3.0-or-later
"""The free end of a front by two sub-models that the run of the whole drives."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fretfe.case import changed, parse_case
from fretfe.cli.exchange import submodel
from fretfe.errors import CaseError
from fretfe.exchange.submodel import told, write_submodel
from fretfe.mesh.load import made_mesh
from fretfe.report.page.ends import end_tables
from fretfe.report.page.tables import front_texts
from fretfe.results.end_answers import read_answers
from fretfe.results.field_files import DISPLACEMENTS, FieldReader
from fretfe.results.front_ends import free_ends, worst_end
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.runner import Runner

LENGTH = 3.0
BODIES = ("upper", "lower")


def pad() -> dict[str, object]:
    """A pad on a block, pressed and sheared in eight steps; its middle is a plane of symmetry."""
    sizes = {"upper_radius": 50, "upper_width": 3, "lower_radius": 0, "lower_width": 3}
    top = {"type": "platen", "boundary": "upper_top", "control": "force"}
    values = [300.0, -300.0, 300.0]
    shear = [{"hold": True, "until": 1.0}, {"times": [2, 3, 4], "values": values}]
    middle = {f"{name}_middle": {"boundary": f"{name}_front", "fix": ["z"]} for name in BODIES}
    return {
        "geometry": {
            "template": "cylinder",
            "parameters": {**sizes, "size": 0.1},
            "solid": {"length": LENGTH, "layers": 3},
        },
        "bodies": {name: {"young": 210e3, "poisson": 0.3} for name in BODIES},
        "contacts": {
            "main": {"surface1": "upper_contact", "surface2": "lower_contact", "friction": 0.4}
        },
        "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}, **middle},
        "loads": {
            "press": top
            | {"direction": "y", "history": [{"ramp": -1800.0, "until": 1.0, "steps": 2}]},
            "shear": top | {"direction": "x", "history": shear},
        },
        "cycle": {"start": 2.0, "end": 4.0},
        "edges": {"local": False, "stations": 12},
        "output": {"fields": "all"},
    }


@pytest.fixture(scope="module")
def whole(runner: Runner, tmp_path_factory: pytest.TempPathFactory) -> Result:
    """With layers of a third of its length, half of what the contact is wide."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    runner.run(parse_case(pad()), folder)
    return load_result(folder)


def test_the_part_is_fine_towards_its_end(whole: Result, tmp_path: Path) -> None:
    ends = list(free_ends(whole))
    # At the plane of symmetry there is none.
    assert len(ends) == 2
    for end in ends:
        np.testing.assert_allclose(end.point[1:], 0.0, atol=0.01)
        np.testing.assert_allclose(end.into, [0.0, 0.0, 1.0], atol=0.05)
    deep = replace(whole, case=changed(whole.case, {"output.stress_depths": [0.2, 0.3]}))
    found = write_submodel(deep, ends[0].name, tmp_path)
    fine, coarse = found.cases
    part, solid, twice = fine.geometry.part, fine.geometry.solid, coarse.geometry.solid
    assert part is not None and solid is not None and twice is not None
    np.testing.assert_allclose(part.centre, ends[0].point, atol=1e-5)
    # Twice the half-width of Hertz's contact, .57.
    assert part.radius == found.radius == pytest.approx(1.14, abs=0.07)
    assert [each.geometry.parameters["size"] for each in found.cases] == [0.05, 0.1]
    for each, times in ((solid, 1), (twice, 2)):
        equal = LENGTH / each.layers
        assert each.layers == math.ceil(12 * LENGTH / (times * part.radius))
        # Elements across a contact of .57 are longer than a twelfth of it.
        assert each.end_size == pytest.approx(min(times * ends[0].station.size, equal), rel=5e-3)
    # For `assess`; nobody judges the second level.
    assert (fine.output.stress_depths, coarse.output.stress_depths) == ((0.2, 0.3), ())
    assert coarse.output.fields == "none"
    # What is left of the free faces bears nothing, and is held by nothing.
    mesh = made_mesh(fine)
    assert {"upper_back", "lower_back"} <= {
        name for body in mesh.bodies.values() for name in body.boundaries
    }
    assert not fine.supports and set(fine.loads) == {"upper_cut", "lower_cut"}
    assert "around the free end main.1" in "\n".join(told(found, "mm"))


def test_what_is_no_end_of_layers(whole: Result, tmp_path: Path) -> None:
    end = next(free_ends(whole))
    other = end.name.replace("start", "nd").replace("end", "start").replace("nd", "end")
    with pytest.raises(CaseError, match="expected one of the free ends main"):
        write_submodel(whole, other, tmp_path)
    refined = replace(whole, case=changed(whole.case, {"edges.tolerance": 0.1}))
    with pytest.raises(CaseError, match=r"--size: expected that of the elements across"):
        write_submodel(refined, end.name, tmp_path)
    assert whole.directory is not None
    with pytest.raises(CaseError, match="--run: expected a free end"):
        submodel(whole.directory, "main", tmp_path, radius=1.5, solve=True)


@pytest.mark.slow
def test_images_of_an_end_agree(
    runner: Runner, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Sheared to and fro, the two fronts of the pad are images of one another."""
    runner.run(changed(parse_case(pad()), {"edges.ends": True, "output.fields": "none"}), tmp_path)
    whole = load_result(tmp_path)
    (one,) = read_answers(whole)
    worst = worst_end(whole)
    assert worst is not None and worst.name == one.name
    (image,) = {each.name for each in free_ends(whole)} - {one.name}
    submodel(tmp_path, image, solve=True, length=one.length)
    out, text = capsys.readouterr().out, " ".join(front_texts(whole))
    assert f"Free end {image}" in out and f"Free end {image}" in text
    # The states of the run and of nothing else drive the parts, by their displacements alone.
    driven = FieldReader(tmp_path / DISPLACEMENTS)
    np.testing.assert_allclose(driven.times, whole.loads.times[1:])
    tables = end_tables(whole)
    assert {str(each.title).rpartition(" ")[2] for each in tables} == {one.name, image}
    assert all(each.row_count == len(one.numbers) for each in tables)
    other = next(each for each in read_answers(whole) if each.name == image)
    for first, second in zip(one.numbers, other.numbers, strict=True):
        # Meshes are not images of one another.
        if first.name == "slip_range":
            # Extrapolated to the edge, from nodes that lie elsewhere.
            bars = math.hypot(first.mean_spread, second.mean_spread)
            assert abs(first.mean - second.mean) < bars < 0.05 * first.mean
            continue
        assert first.mean == pytest.approx(second.mean, rel=2e-3), first
        assert first.mean_spread > 0
    assert one.numbers[0].name == "work"
    assert one.numbers[0].mean_spread < 0.1 * one.numbers[0].mean
    # All of the part is within a half-width of its ends.
    assert not len(one.distance) and "|ΔK| means nothing in the part" in text
