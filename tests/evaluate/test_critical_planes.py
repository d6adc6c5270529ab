# SPDX-License-Identifier: LGPL-3.0-or-later
"""Parameters on critical planes against closed forms, turned bodies and a brute-force search."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from fretfe._typing import Array
from fretfe.errors import CaseError
from fretfe.evaluate.critical_planes import (
    Critical,
    Parameter,
    fatemi_socie,
    find_critical,
    findley,
    smith_watson_topper,
)

E, NU = 210e3, 0.3
G = E / (2 * (1 + NU))
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
# The last step of the search is a tenth of a degree: parameters are flat at their largest.
SEARCHED = 1e-4


def critical(stress: Array, parameter: Parameter) -> Critical:
    """Of an isotropic body."""
    strain = (1 + NU) / E * stress
    strain[..., :3] -= NU / E * stress[..., :3].sum(axis=2, keepdims=True)
    return find_critical(stress, strain, parameter)


def packed(tensors: Array) -> Array:
    """(n, 1, 6) from (n, 3, 3)."""
    return np.stack([tensors[:, i, j] for i, j in PAIRS], axis=1)[:, None]


def uniaxial(values: Array) -> Array:
    tensors = np.zeros((len(values), 3, 3))
    tensors[:, 0, 0] = values
    return tensors


def torsion(amplitude: float) -> Array:
    tensors = np.zeros((2, 3, 3))
    tensors[:, 0, 1] = tensors[:, 1, 0] = [amplitude, -amplitude]
    return tensors


def rotated(tensors: Array, seed: int = 3) -> Array:
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return np.asarray(turn @ tensors @ turn.T)


@pytest.mark.parametrize("ratio", [-1.0, 0.0, 0.5, -3.0])
def test_uniaxial_tension(ratio: float) -> None:
    """SWT = sigma_max eps_a on the plane across the load; zero only if it is never pulled."""
    found = critical(packed(uniaxial(np.array([300.0, ratio * 300]))), smith_watson_topper)
    assert found.value[0] == pytest.approx(300 * 300 * (1 - ratio) / (2 * E), rel=SEARCHED)
    assert abs(found.normal[0, 0]) == pytest.approx(1, abs=1e-5)


def test_push_pull_shears_most_at_45_degrees() -> None:
    """tau_a = sigma_a/2 there, gamma_a = (1 + nu) sigma_a/E, and sigma_n,max = sigma_a/2."""
    history = packed(uniaxial(np.array([300.0, -300.0])))
    alone = critical(history, fatemi_socie(0.0, 1.0))
    assert alone.value[0] == pytest.approx((1 + NU) * 300 / E, rel=SEARCHED)
    # With angle w of the normal: sin 2w (1 + k cos^2 w s/sy), the largest of which is brute force.
    angle = np.linspace(0, np.pi / 2, 100_001)
    both = (1 + NU) * 300 / E * np.sin(2 * angle) * (1 + 0.8 * np.cos(angle) ** 2 * 300 / 400)
    found = critical(history, fatemi_socie(0.8, 400.0))
    assert found.value[0] == pytest.approx(both.max(), rel=SEARCHED)
    assert abs(found.normal[0, 0]) == pytest.approx(np.cos(angle[both.argmax()]), abs=2e-3)


def test_torsion() -> None:
    """Principal stresses +-tau at 45 degrees; largest shear where nothing pulls."""
    history = packed(torsion(200.0))
    swt = critical(history, smith_watson_topper)
    assert swt.value[0] == pytest.approx(200**2 * (1 + NU) / E, rel=SEARCHED)
    assert np.abs(swt.normal[0]) == pytest.approx([np.sqrt(0.5), np.sqrt(0.5), 0], abs=2e-3)
    shear = critical(history, fatemi_socie(0.0, 1.0))
    assert shear.value[0] == pytest.approx(200 / G, rel=SEARCHED)


def test_pressure_alone_does_no_damage_by_tension() -> None:
    history = packed(uniaxial(np.array([-300.0, 0.0])))
    assert critical(history, smith_watson_topper).value[0] == 0
    # Pressed planes count as if nothing pressed them.
    pressed = critical(history, fatemi_socie(1.0, 300.0)).value[0]
    assert pressed == pytest.approx((1 + NU) * 150 / E, rel=SEARCHED)


def test_what_is_unknown_stays_unknown() -> None:
    history = np.concatenate([packed(torsion(1.0)), packed(torsion(2.0))], axis=1)
    history[1, 0, 3] = np.nan
    found = critical(history, smith_watson_topper)
    assert np.isnan(found.value[0])
    assert np.isnan(found.normal[0]).all()
    assert found.value[1] > 0


@pytest.mark.parametrize("numbers", [(-0.1, 300.0), (0.5, 0.0), (np.nan, 300.0)])
def test_numbers_of_fatemi_and_socie_are_checked(numbers: tuple[float, float]) -> None:
    with pytest.raises(CaseError, match="expected k >= 0 and a yield stress > 0"):
        fatemi_socie(*numbers)


def random_history(seed: int) -> Array:
    """Twelve states of a stress whose axes turn."""
    values = np.random.default_rng(seed).normal(size=(12, 3, 3))
    return 100 * (values + values.swapaxes(1, 2))


PARAMETERS = {"swt": smith_watson_topper, "fatemi-socie": fatemi_socie(0.7, 350.0)}


@pytest.mark.parametrize("name", PARAMETERS)
@pytest.mark.parametrize("seed", range(4))
def test_a_turned_body_has_the_same_parameters(name: str, seed: int) -> None:
    history, parameter = random_history(seed), PARAMETERS[name]
    one, other = (
        critical(packed(each), parameter).value[0] for each in (history, rotated(history, seed))
    )
    # Another grid may lead to another hill of nearly the same height.
    assert other == pytest.approx(one, rel=5e-3)


@pytest.mark.parametrize("name", PARAMETERS)
def test_search_against_all_planes(name: str) -> None:
    """Every plane of a grid of one degree, with all pairs of states."""
    history = random_history(11)
    trace = np.trace(history, axis1=1, axis2=2)
    best = 0.0
    for tilt in np.radians(np.arange(0, 91)):
        for turn in np.radians(np.arange(0, 360, 1.0 / max(np.sin(tilt), 0.02))):
            sine, cosine = np.sin(tilt), np.cos(tilt)
            normal = np.array([sine * np.cos(turn), sine * np.sin(turn), cosine])
            pull = history @ normal
            normal_stress = pull @ normal
            strain = ((1 + NU) * normal_stress - NU * trace) / E
            top = max(normal_stress.max(), 0.0)
            if name == "swt":
                best = max(best, top * np.ptp(strain) / 2)
            else:
                sheared = (pull - normal_stress[:, None] * normal) / G
                best = max(best, pdist(sheared).max() / 2 * (1 + 0.7 * top / 350))
    found = critical(packed(history), PARAMETERS[name]).value[0]
    # The grid misses the top by at most half a degree, 1 - cos(1 degree) = 1.5e-4 or so.
    assert found == pytest.approx(best, rel=1e-3)


@pytest.mark.parametrize("k", [0.0, 0.25, 1.0])
def test_findley_of_tension_and_torsion(k: float) -> None:
    root = np.sqrt(1 + k**2)
    twisted = critical(packed(rotated(torsion(200.0))), findley(k))
    assert twisted.value[0] == pytest.approx(200 * root, rel=SEARCHED)
    pulled = critical(packed(uniaxial(np.array([300.0, -300.0]))), findley(k))
    assert pulled.value[0] == pytest.approx(300 * (k + root) / 2, rel=SEARCHED)
