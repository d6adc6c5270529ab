# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs outside the model say which limit is exceeded, and by how much; runs inside say nothing."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from cases.chains import surface
from cases.pad_cases import HOLD, STEEL, cylinder, pad, press, shear, wave
from cases.sheets import sheet
from cases.solid_runs import sphere
from cases.solid_runs import surface as bent
from reference.closed_forms import closed_contact

from fretfe._typing import Array
from fretfe.backends import find_backend
from fretfe.case import parse_case
from fretfe.evaluate.limits import ModelLimit
from fretfe.fem.limits import LARGEST_IMBALANCE, _along_surface, _deformation, depth, imbalance
from fretfe.history.solution import ContactHistory
from fretfe.quality.validation import validate
from fretfe.reason import Kind
from fretfe.report.page.html import render
from fretfe.report.page.tables import station_table
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.writer import write_results
from fretfe.surface.surface import tangent_frames

COARSE = {"size": 0.04}
TWO_CYLINDERS = {"template": "cylinder", "parameters": COARSE}
SLIDING = "sliding over the width of the contact"
RADIUS = "sliding over the sum of the radii of both surfaces"
ROTATION = "rotation of a body at the contact"
PRESSURE = "largest pressure over the plane modulus"
STRETCH = "stretch of a surface, root mean square over the contact"
PAIRING = "bound of the error of ΔK_T by gap times rotation"


def moved(distance: float) -> dict[str, Any]:
    ramp = {"ramp": distance, "until": 2.0, "steps": 4}
    return {
        "press": press(),
        "shear": {**shear(), "control": "displacement", "history": [HOLD, ramp]},
    }


def of_steel(factor: float) -> dict[str, Any]:
    """Both bodies with this multiple of the modulus of steel."""
    return {name: {**STEEL, "young": factor * STEEL["young"]} for name in ("upper", "lower")}


def limits(result: Result) -> dict[str, ModelLimit]:
    return {limit.quantity: limit for limit in result.limits}


def test_a_pad_that_is_pulled_off_says_in_which_step_it_opens(solved: Any) -> None:
    """P = 600 at t = 1, 0 in the second of three steps behind it, and a pull of 300 in the last."""
    pulled = {"ramp": 300.0, "until": 2.0, "steps": 3}
    loads = {"press": {**press(), "history": [{"ramp": -600.0, "until": 1.0, "steps": 2}, pulled]}}
    result = solved(pad(geometry=cylinder(size=0.1), loads=loads))
    assert "The contact opens at step 4: no contact is left" in str(result.failure)
    assert result.contacts[0].normal_force == pytest.approx([0, 300, 600, 300, 0], abs=1e-6)
    # The edges are those of the largest load.
    assert station_table(result) is not None
    assert [station.decisive for station in result.contacts[0].stations] == [2, 2]


def test_the_pairing_error_of_no_shear_is_not_measured(solved: Any) -> None:
    """Q = 1e-8 beside P = 1e3 is round-off, and so is what rotation does to its K_T."""
    loads = {"press": press(1000.0, steps=2), "shear": shear(1e-8, cycles=1, steps=4)}
    result = solved(pad(geometry=cylinder(size=0.1), loads=loads))
    assert math.isnan(limits(result)[PAIRING].found)


def test_a_pad_is_within_all_limits(solved: Any) -> None:
    result = solved(pad(geometry=cylinder(size=0.02)))
    assert [limit.verdict for limit in result.limits] == ["within"] * len(result.limits)
    # Hertz: p0/(E/(1 - nu^2)) = a/(4 R), and the steepest slope of one body a/(2 R).
    assert limits(result)[PRESSURE].found == pytest.approx(0.5749 / 200, rel=0.01)
    slope = limits(result)["largest slope that a surface takes in the contact"].found
    assert slope == pytest.approx(0.5749 / 100, rel=0.05)


def test_two_millimetres_of_sliding_are_too_much_for_cylinders_of_eight(solved: Any) -> None:
    result = solved(pad(geometry=TWO_CYLINDERS, loads=moved(2.0)))
    # The contact is 2 x 0.18 mm wide; elasticity takes a little of the 2 mm.
    assert limits(result)[SLIDING].found == pytest.approx(5.5, rel=0.05)
    assert limits(result)[RADIUS].found == pytest.approx(2 / 16, rel=0.02)
    warnings = "; ".join(each.sentence for each in result.warnings)
    assert "sliding over the width of the contact is 5.5, expected at most 0.1: " in warnings
    assert "sliding over the sum of the radii of both surfaces is 0.12" in warnings


def test_sliding_beyond_the_end_of_a_surface(solved: Any) -> None:
    result = solved(pad(geometry=TWO_CYLINDERS, loads=moved(50.0)))
    assert limits(result)[SLIDING].found > 100


def test_strains_of_order_one(solved: Any) -> None:
    result = solved(pad(geometry=cylinder(**COARSE), bodies=of_steel(1e-3)))
    found = limits(result)
    assert found[PRESSURE].found > 10 and found[STRETCH].found > 0.5
    assert found[PRESSURE].exceeded and found[STRETCH].exceeded and found[ROTATION].exceeded


def test_a_column_that_leans(solved: Any) -> None:
    def leaning(height: float, width: float, normal: float, sideways: float) -> Any:
        geometry = cylinder(**COARSE, upper_height=height, upper_width=width)
        loads = {"press": press(normal), "shear": shear(sideways, steps=8)}
        return limits(solved(pad(geometry=geometry, bodies=of_steel(0.2), loads=loads)))

    assert leaning(60.0, 6.0, 600.0, 200.0)[ROTATION].found > 0.01
    # There the contact moves to the end of its surface, so that no K_T is known; here it does not.
    assert leaning(200.0, 3.0, 150.0, 0.5)[PAIRING].found > 0.01


@pytest.mark.parametrize("height", [12.0, 30.0])
def test_the_pairing_error_bounds_that_of_k_t(solved: Any, height: float) -> None:
    """Two equal cylinders: K_T is too high, by less than the limit says."""
    sizes = {"size": 0.01, "zone": 0.6, "upper_height": height, "lower_height": height}
    case = pad(geometry={"template": "cylinder", "parameters": sizes})
    result, exact = solved(case), closed_contact(parse_case(case))
    (station, _), (true, _) = (each.stations for each in (result.contacts[0], exact))
    error = station.k_t_range / true.k_t_range - 1
    assert 0.001 < error < limits(result)[PAIRING].found < 0.01


@pytest.mark.parametrize(("upper", "warned"), [((70e3, 0.3), False), ((5e3, 0.1), True)], ids=str)
def test_dissimilar_bodies_with_friction(
    solved: Any, upper: tuple[float, float], warned: bool
) -> None:
    """Dundurs' beta of -.14, and of -.42, for which nothing was measured."""
    bodies = {**of_steel(1.0), "upper": dict(zip(("young", "poisson"), upper, strict=True))}
    loads = {"press": press(), "shear": {**shear(), "history": [HOLD, wave(30.0, steps=8)]}}
    result = solved(pad(geometry=cylinder(**COARSE), bodies=bodies, loads=loads))
    assert (Kind.DUNDURS in {each.kind for each in result.warnings}) == warned
    assert all(np.isnan(station.k_n_moved) for station in result.contacts[0].stations)


PARTS = ("imbalance", "scale")


def test_equilibrium_is_judged(solved: Any) -> None:
    result = solved(pad(geometry=cylinder(**COARSE)))
    solution = result.solution
    assert imbalance(solution) is None
    for kind in ("force", "moment"):
        wrong = solution.certificates[f"{kind}_imbalance"].copy()
        wrong[3] += 1e-3 * solution.certificates[f"{kind}_scale"].max()
        broken = {**solution.certificates, f"{kind}_imbalance": wrong}
        failure = imbalance(replace(solution, certificates=broken))
        assert f"step 3: expected {kind}s that balance" in str(failure)
        # Bodies that have parted: round-off beside nothing.
        parted = {name: solution.certificates[f"{kind}_{name}"].copy() for name in PARTS}
        parted["imbalance"][3] = parted["scale"][3] = 1e-13 * parted["scale"].max()
        nothing = {f"{kind}_{name}": values for name, values in parted.items()}
        certificates = {**solution.certificates, **nothing}
        assert imbalance(replace(solution, certificates=certificates)) is None
        largest = solution.certificates[f"{kind}_scale"].max()
        assert solution.certificates[f"{kind}_imbalance"].max() < 1e-11 * largest
    assert limits(result)["sum of the forces on a body over that of their sizes"].found < (
        LARGEST_IMBALANCE
    )


def test_depth_of_points_behind_a_surface() -> None:
    x = np.linspace(0.0, 1.0, 11)
    # A chain has its body on the left: below if it runs towards smaller x.
    flat = surface("flat", np.stack([x[::-1], 0 * x], axis=1), curved=False)
    facets = flat.nodes
    assert depth(np.array([[0.52, -0.05]]), facets, flat) == pytest.approx(0.05 - 0.001)
    assert depth(np.array([[0.52, 0.05], [1.5, -0.05]]), facets, flat) == 0.0


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("down", [False, True])
def test_depth_in_space(cell: str, order: int, down: bool) -> None:
    """A dome: a surface of a body below it, or of one above, that is deformed by .02."""
    x = np.linspace(-0.5, 0.5, 21)

    def dome(points: Array) -> Array:
        return np.column_stack([points, -0.25 * (points**2).sum(axis=1)])

    surface = sheet("dome", x, x, cell, order, dome, down=down)
    side = 1.0 if down else -1.0
    moved = surface.nodes + np.array([0.0, 0.0, 0.02])
    inside = np.array([0.21, -0.14, -0.25 * (0.21**2 + 0.14**2) + 0.02])
    slope = 0.5 * np.hypot(0.21, 0.14)
    below = np.array([0.0, 0.0, side * 0.05])
    found = depth((inside + below)[None], moved, surface)
    # A facet is .05 wide, of which .01 is allowed; flat ones are up to .0003 off the dome, and as
    # much again is allowed.
    accuracy = 4e-4 if order == 2 else 8e-4
    assert found == pytest.approx(0.05 / np.hypot(1.0, slope) - 0.0005, abs=accuracy)
    assert depth((inside - below)[None], moved, surface) == 0.0
    assert depth(np.array([[0.9, 0.0, side * 0.05]]), moved, surface) == 0.0


def test_limits_are_written_read_shown_and_validated(tmp_path: Path) -> None:
    case = parse_case(pad(geometry=TWO_CYLINDERS, loads=moved(2.0)))
    validation = validate(case, find_backend("fem"))
    rows = {row.quantity: row for row in validation.rows}
    assert rows[SLIDING].verdict == "unknown" and rows[PRESSURE].verdict == "agrees"
    assert not validation.passed
    write_results(tmp_path, replace(validation.result, backend="fem"))
    read = load_result(tmp_path)
    assert [limit.verdict for limit in read.limits] == [
        limit.verdict for limit in validation.result.limits
    ]
    page = render(tmp_path)
    assert "Limits of the model" in page and '<td class="verdict exceeded">exceeded</td>' in page


@pytest.mark.parametrize("corners", [3, 4])
def test_rotation_and_strain_of_a_curved_surface(corners: int) -> None:
    shape = replace(sphere(), facets=bent(corners=corners).facets)
    frames = tangent_frames(shape.normals)
    history = cast(
        ContactHistory,
        SimpleNamespace(
            surface=SimpleNamespace(facets=shape.facets, points=shape.points, frames=frames)
        ),
    )
    derive = _along_surface(history)
    turn = np.array([1e-3, 2e-3, -3e-3])
    inner = np.linalg.norm(shape.plane, axis=1) < 1.2
    rotation, tilt, strain = _deformation(derive(np.cross(turn, shape.points)[None]), frames)
    assert np.abs(rotation[0, inner] - turn).max() < 3e-6
    about_normal = shape.normals @ turn
    np.testing.assert_allclose(
        tilt[0, inner] ** 2, (turn @ turn - about_normal**2)[inner], rtol=0.01
    )
    assert strain[0, inner].max() < 1e-5
    # A stretch along x alone is that of the surface where it is level.
    middle = int(np.argmin(np.linalg.norm(shape.plane, axis=1)))
    stretched = derive((shape.points * np.array([1e-3, 0.0, 0.0]))[None])
    rotation, _, strain = _deformation(stretched, frames)
    assert strain[0, middle] == pytest.approx(1e-3, rel=0.01)
    assert np.abs(rotation[0, middle]).max() < 1e-6
