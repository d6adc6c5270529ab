# SPDX-License-Identifier: LGPL-3.0-or-later
"""Crystals in the case file: constants, orientations, moduli, and what is wrong with them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cases.pad_cases import SLIDING, STEEL, pad, press, pull, shear

from fretfe.backends.halfplane import BACKEND as HALFPLANE
from fretfe.case import Body, Case, Crystal, changed, check_dimension, isotropic, parse_case
from fretfe.errors import CaseError
from fretfe.history.solution import SLIP
from fretfe.idealise.bodies import cross_compliance, dissimilarity, read_block, side_tension
from fretfe.idealise.case import idealise, obstacles
from fretfe.materials.crystals import bunge_rotation, cubic
from fretfe.materials.crystals import isotropic as isotropic_stiffness
from fretfe.materials.moduli import contact_modulus, normal_modulus, plane_modulus
from fretfe.mesh.templates import check_parameters, find_template

NICKEL = {"cubic": [252e3, 161e3, 131e3]}
# About x: an orthotropic material that is turned within the plane of y and z.
ORTHOTROPIC = {
    "young": [120e3, 80e3, 60e3],
    "poisson": [0.3, 0.25, 0.2],
    "shear": [40e3, 30e3, 20e3],
}
NORMAL = np.array([0.0, 1.0])
PARAMETERS = check_parameters(find_template("cylinder"), pad()["geometry"]["parameters"])
MATRIX = isotropic_stiffness(210e3, 0.3)


def case_of(upper: dict[str, Any], lower: dict[str, Any] | None = None, **changes: Any) -> Case:
    return parse_case(pad(bodies={"upper": upper, "lower": lower or upper}, **changes))


def crystal(**orientation: Any) -> Crystal:
    body = case_of({"elastic": NICKEL, "orientation": orientation}).bodies["upper"]
    assert isinstance(body, Crystal)
    return body


def refused(elastic: Any, **keys: Any) -> str:
    with pytest.raises(CaseError) as error:
        case_of({"elastic": elastic, **keys}, STEEL)
    lines = str(error.value).splitlines()
    assert len(lines) == 1
    return lines[0]


def test_one_orientation_in_four_ways() -> None:
    euler = crystal(euler=[20.0, 40.0, 70.0])
    axes = bunge_rotation((20.0, 40.0, 70.0))
    # A direction of the model in the crystal is a column.
    x, y, z = (axes[:, i].tolist() for i in range(3))
    others = [
        crystal(matrix=axes.tolist()),
        crystal(x=x, y=y),
        crystal(z=z, x=x),
        crystal(y=y, z=z),
    ]
    for other in others:
        np.testing.assert_allclose(other.stiffness, euler.stiffness, atol=1e-9)
    assert np.abs(euler.stiffness - crystal().stiffness).max() > 1e4


def test_directions_may_have_any_length_and_four_digits() -> None:
    exact = crystal(x=[1, 1, 0], y=[-1, 1, 0]).stiffness
    rounded = crystal(x=[0.7071, 0.7071, 0], y=[-70.71, 70.71, 0.001]).stiffness
    np.testing.assert_allclose(rounded, exact, atol=5.0)
    np.testing.assert_allclose(crystal(euler=[-45.0, 0, 0]).stiffness, exact, atol=1e-9)


def test_orthotropic_constants_are_those_of_tension_and_shear() -> None:
    body = case_of({"elastic": {"orthotropic": ORTHOTROPIC}}).bodies["upper"]
    assert isinstance(body, Crystal)
    compliance = np.linalg.inv(body.stiffness)
    np.testing.assert_allclose(1 / compliance.diagonal()[:3], ORTHOTROPIC["young"], rtol=1e-12)
    nu = -compliance[[0, 0, 1], [1, 2, 2]] / compliance.diagonal()[[0, 0, 1]]
    np.testing.assert_allclose(nu, ORTHOTROPIC["poisson"], rtol=1e-12)
    # G12, G13, G23 in Voigt's order are 66, 55, 44.
    np.testing.assert_allclose(1 / compliance.diagonal()[:2:-1], ORTHOTROPIC["shear"], rtol=1e-12)


@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_isotropic_constants_in_21_numbers(plane: Any) -> None:
    body = case_of({"elastic": {"constants": MATRIX[np.triu_indices(6)].tolist()}}).bodies["upper"]
    known = isotropic(body)
    assert known is not None and known.young == pytest.approx(210e3, rel=1e-13)
    steel = Body(young=210e3, poisson=0.3)
    expected = contact_modulus(steel, steel, plane)
    assert contact_modulus(body, body, plane) == pytest.approx(expected, rel=1e-12)


def test_moduli_of_crystals() -> None:
    body = crystal()
    # Of theory, 2/A_n; what shear and pressure see is the same about <001>.
    assert normal_modulus(body, "strain", NORMAL) == pytest.approx(2 / 9.14631e-6, rel=1e-6)
    turned = crystal(euler=[25.0, 0.0, 0.0])
    assert normal_modulus(turned, "strain", NORMAL) == pytest.approx(2 / 9.14631e-6, rel=1e-6)
    stiffness = cubic(*NICKEL["cubic"])
    compliance = np.linalg.inv(stiffness)
    assert plane_modulus(body, "stress") == pytest.approx(1 / compliance[0, 0], rel=1e-12)
    held = compliance[0, 0] - compliance[0, 1] ** 2 / compliance[0, 0]
    assert plane_modulus(body, "strain") == pytest.approx(1 / held, rel=1e-12)
    # Of a half-space the mean over all directions, between the largest and the smallest.
    space = [normal_modulus(body, "strain", np.array(n)) for n in ([0, 1.0, 0], [0, 0.6, 0.8])]
    assert space[0] == pytest.approx(2 / 9.14631e-6, rel=0.1) and space[1] > space[0]


def test_similar_bodies() -> None:
    one, turned = crystal(), crystal(euler=[25.0, 0.0, 0.0])
    steel = Body(young=210e3, poisson=0.3)
    assert dissimilarity(one, turned, "strain", NORMAL) < 1e-9
    assert dissimilarity(one, steel, "strain", NORMAL) == pytest.approx(
        (2.47619e-6 - 2.42131e-6) / (9.14631e-6 + 8.66667e-6), rel=1e-3
    )
    assert cross_compliance(one, turned, "strain", NORMAL) < 1e-9
    # In space a direction that is no axis of symmetry couples pressure with shear.
    skew = crystal(euler=[0.0, 20.0, 0.0])
    assert cross_compliance(skew, skew, "strain", np.array([0.0, 1.0, 0.0])) > 0.01
    assert dissimilarity(skew, skew, "strain", np.array([0.0, 1.0, 0.0])) == 0


HOSTILE: dict[str, tuple[Any, dict[str, Any], str]] = {
    "soft": ({"cubic": [100.0, 200.0, 50.0]}, {}, "eigenvalue -100"),
    "no shear": ({"cubic": [100.0, 50.0, 0.0]}, {}, "eigenvalue 0"),
    "twenty": ({"constants": [1.0] * 20}, {}, "constants: expected at least 21 entries, found 20"),
    "more": ({"constants": [1.0] * 22}, {}, "constants: expected at most 21 entries, found 22"),
    "singular": ({"constants": [1.0] * 21}, {}, "positive definite stiffness"),
    "poisson": (
        {"orthotropic": {**ORTHOTROPIC, "poisson": [1.3, 0.25, 0.2]}},
        {},
        "positive definite compliance), found a compliance with the eigenvalue -",
    ),
    "poisson at the limit": (
        {"orthotropic": {"young": [4.0, 1.0, 1.0], "poisson": [2.0, 0, 0], "shear": [1, 1, 1]}},
        {},
        "elastic: expected constants by which every strain takes energy",
    ),
    "none": ({}, {}, "expected exactly one of 'cubic', 'orthotropic' and 'constants', found none"),
    "two": ({**NICKEL, "constants": [1.0] * 21}, {}, "found 'cubic' and 'constants'"),
    "number": (210e3, {}, "bodies.upper.elastic: expected a table, found 210000.0"),
    "text": ({"cubic": ["a", 1.0, 2.0]}, {}, "elastic.cubic[item 1]: expected a number"),
    "unknown": ({"hexagonal": [1.0]}, {}, "elastic.hexagonal: unknown key, expected one of"),
    "modulus too": (
        NICKEL,
        {"young": 1.0},
        "bodies.upper: expected either 'young' and 'poisson', or 'elastic' and perhaps an "
        "'orientation' of a crystal, found 'young' and 'elastic'",
    ),
    "parallel": (NICKEL, {"orientation": {"x": [1, 1, 0], "y": [2, 2, 0]}}, "found 0.0 degrees"),
    "askew": (NICKEL, {"orientation": {"x": [1, 1, 0], "z": [1, 1, 1]}}, "found 35.3 degrees"),
    "nothing": (NICKEL, {"orientation": {"x": [0, 0, 0], "z": [0, 0, 1]}}, "found a zero vector"),
    "one": (NICKEL, {"orientation": {"x": [1, 1, 0]}}, "expected two of the directions"),
    "three": (
        NICKEL,
        {"orientation": {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1]}},
        "found 'x' and 'y' and 'z'",
    ),
    "ways": (
        NICKEL,
        {"orientation": {"euler": [0, 0, 0], "x": [1, 0, 0], "y": [0, 1, 0]}},
        "'euler'",
    ),
    "stretched": (
        NICKEL,
        {"orientation": {"matrix": [[2, 0, 0], [0, 1, 0], [0, 0, 1]]}},
        "expected a rotation",
    ),
    "mirrored": (
        NICKEL,
        {"orientation": {"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, -1]]}},
        "the determinant -1",
    ),
    "two angles": (NICKEL, {"orientation": {"euler": [0, 0]}}, "orientation.euler[item 3]"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_wrong_crystals_are_refused(name: str) -> None:
    elastic, keys, expected = HOSTILE[name]
    text = refused(elastic, **keys)
    assert "bodies.upper" in text and expected in text


def test_an_orientation_alone_is_of_a_crystal() -> None:
    with pytest.raises(CaseError, match=r"bodies\.upper\.elastic: expected a value"):
        case_of({"orientation": {"euler": [0, 0, 0]}}, STEEL)
    with pytest.raises(CaseError, match=r"upper: expected either .* found 'young' and 'poisson' a"):
        case_of({"orientation": {"euler": [0, 0, 0]}, **STEEL}, STEEL)


def test_overrides_turn_a_crystal() -> None:
    case = case_of({"elastic": NICKEL, "orientation": {"euler": [0.0, 0.0, 0.0]}})
    other = changed(case, {"bodies.upper.orientation.euler": [30.0, 0.0, 0.0]})
    body, same = other.bodies["upper"], crystal(euler=[30.0, 0.0, 0.0])
    assert isinstance(body, Crystal)
    np.testing.assert_array_equal(body.stiffness, same.stiffness)
    assert other != case


def test_supports_along_z_stay_while_a_sweep_turns_a_crystal() -> None:
    """Some of its angles move the plane bodies along z, others do not."""
    base = {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}
    for angle, components in ((0.0, 2), (30.0, 3), (45.0, 2)):
        upper = {"elastic": NICKEL, "orientation": {"euler": [90.0, angle, -90.0]}}
        case = case_of(upper, STEEL, supports={"base": base})
        check_dimension(case, 2)
        assert case.components(2) == components
    with pytest.raises(CaseError, match=r"supports\.base\.fix.* found 'z'; the mesh is plane"):
        check_dimension(case_of(STEEL, STEEL, supports={"base": base}), 2)


def test_half_planes_of_a_crystal_do_not_depend_on_the_angle() -> None:
    found = []
    for angle in (0.0, 15.0, 33.0, 45.0):
        body = {"elastic": NICKEL, "orientation": {"euler": [angle, 0.0, 0.0]}}
        case = case_of(body, loads={"press": press(steps=2), "shear": shear(cycles=1, steps=8)})
        assert idealise(case).profile.e_star == pytest.approx(1 / 9.14631e-6, rel=1e-6)
        solution = HALFPLANE.solve(case).solution
        found.append(np.asarray(solution.contacts[0].traction))
        assert (np.asarray(solution.contacts[0].status) == SLIP).any()
    first, *others = found
    for other in others:
        assert np.abs(other - first).max() < 1e-9 * first.max()


def test_half_planes_of_an_orthotropic_crystal() -> None:
    """Tractions are those of the isotropic body with its A_n, slip has A_t, a pull sigma0 s'11/A_t.

    A_n = sqrt(s'22) kappa, A_t = sqrt(s'11) kappa, kappa^2 = 2 sqrt(s'11 s'22) + 2 s'12 + s'66.
    """
    crystal = {"elastic": {"orthotropic": ORTHOTROPIC}}
    matrix = case_of(crystal).bodies["upper"]
    assert isinstance(matrix, Crystal)
    s = np.linalg.inv(matrix.stiffness)
    s = s - np.outer(s[2], s[2]) / s[2, 2]
    kappa = np.sqrt(2 * np.sqrt(s[0, 0] * s[1, 1]) + 2 * s[0, 1] + s[5, 5])
    normal, tangential = kappa * np.sqrt(s[1, 1]), kappa * np.sqrt(s[0, 0])
    assert tangential / normal == pytest.approx(np.sqrt(s[0, 0] / s[1, 1]), rel=1e-12)
    assert abs(tangential / normal - 1) > 0.1
    same = {"young": 2 / normal * (1 - 0.3**2), "poisson": 0.3}
    answers = []
    # One side carries all of Q: a tension is added to the pull.
    block = read_block("cylinder", PARAMETERS, case_of(crystal))
    more = 60.0 * side_tension(block.half_widths[1], block.heights[1], sliding=True)[0]
    stronger = (40.0 + more) * 2 * s[0, 0] / tangential - more
    for body, tension in ((crystal, 40.0), (same, stronger)):
        loads = {"press": press(), "shear": shear(), "pull": pull(tension)}
        answers.append(HALFPLANE.solve(case_of(body, loads=loads, supports=SLIDING)))
    found, expected = (each.solution.contacts[0] for each in answers if each.solution)
    peak = expected.traction[-1].max()
    # To round-off but at the border of slip, where it is 1e-7.
    np.testing.assert_allclose(found.traction[-1], expected.traction[-1], atol=1e-6 * peak)
    slip = np.ptp(expected.slip[-40:], axis=0)
    np.testing.assert_allclose(
        np.ptp(found.slip[-40:], axis=0), tangential / normal * slip, atol=1e-6 * slip.max()
    )
    half_width = np.sqrt(2 * 600.0 * 50.0 * 2 * normal / np.pi)
    k_n = 2 * 600.0 / (np.pi * half_width) * np.sqrt(2 / half_width)
    for one, other in zip(*(each.contacts[0].stations for each in answers), strict=True):
        assert one.k_n[-1] == pytest.approx(k_n, rel=1e-3)
        assert one.k_t_range == pytest.approx(other.k_t_range, rel=1e-7)


def test_what_half_planes_do_not_know_of_crystals() -> None:
    askew = {"elastic": NICKEL, "orientation": {"euler": [0.0, 20.0, 30.0]}}
    (upper, lower, *_) = obstacles(case_of(askew))
    assert "bodies.upper.orientation: expected one in which z is normal to a plane of symm" in upper
    assert lower.startswith("bodies.lower.orientation")
    turned = {"elastic": {"orthotropic": ORTHOTROPIC}, "orientation": {"euler": [20.0, 0.0, 0.0]}}
    (apart,) = obstacles(case_of(turned))
    assert "to pressure and to shear apart from each other" in apart
    straight = case_of({"elastic": {"orthotropic": ORTHOTROPIC}})
    assert not obstacles(straight)
    soft = {"young": 70e3, "poisson": 0.1}
    assert any("Dundurs' beta" in each for each in obstacles(case_of({"elastic": NICKEL}, soft)))
