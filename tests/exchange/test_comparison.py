# SPDX-License-Identifier: LGPL-3.0-or-later
"""`fretfe compare`: differences of two results are those of closed forms, and all else is said."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import cylinder, pad, press, shear
from cases.solid_runs import (
    FRICTION,
    SHEAR,
    Surface,
    exact_station,
    hertz,
    mindlin,
    solid_result,
    stationed_sphere,
    surface,
    with_stations,
)
from cases.stored_runs import solved, write_run
from harness.launch import fretfe as command
from reference.closed_forms import closed_contact

import fretfe
from fretfe.api import Comparison, Result
from fretfe.case import parse_case
from fretfe.cli.exchange import _print_comparison
from fretfe.errors import CaseError, ConvergenceError
from fretfe.evaluate.contacts import Contact, Front
from fretfe.exchange.comparison import QuantityPair
from fretfe.report.texts import number

LOADS = {"press": press(), "shear": shear(steps=8)}


def run(backend: str = "halfplane", **tables: Any) -> Result:
    return fretfe.run(parse_case(pad(**{"loads": LOADS, **tables})), backend)


@pytest.fixture(scope="module")
def wider() -> Comparison:
    """R = 50 and R = 60."""
    return fretfe.compare(solved("halfplane"), run(geometry=cylinder(upper_radius=60.0)))


def numbers(comparison: Comparison) -> dict[tuple[str, str], QuantityPair]:
    return {(each.edge, each.quantity): each for each in comparison.quantities}


@pytest.mark.parametrize("edge", ["left", "right"])
@pytest.mark.parametrize(
    ("quantity", "power"), [("K_N", -0.75), ("ΔK_T", -0.25), ("d_1", 0.5), ("d_2", 0.5)]
)
def test_edges_of_two_cylinders(wider: Comparison, edge: str, quantity: str, power: float) -> None:
    """By Hertz a goes with the root of R, by (4), (9) and Mindlin the others follow."""
    pair = numbers(wider)[edge, quantity]
    # Fits and slip zones of half-planes of this fineness.
    assert pair.difference == pytest.approx(1.2**power - 1, abs=5e-4)
    assert pair.verdict == "differs"
    assert pair.difference_spread < abs(pair.difference) / 5


def test_tractions_of_two_cylinders(wider: Comparison) -> None:
    """Against the integral of the difference of two Hertz pressures, by quadrature."""
    names = [each.extreme for each in wider.tractions]
    assert names == ["largest K_T at the left edge", "smallest K_T at the left edge"]
    e_star = 210e3 / (2 * (1 - 0.3**2))
    x = np.linspace(-1, 1, 200_001)

    def hertz(radius: float) -> np.ndarray[Any, Any]:
        a = math.sqrt(4 * radius * 600 / (math.pi * e_star))
        return 2 * 600 / (math.pi * a) * np.sqrt(np.clip(1 - (x / a) ** 2, 0, None))

    one, two = hertz(50), hertz(60)
    # Means around the nodes, which both have at other places, for exact values.
    expected = math.sqrt(((two - one) ** 2).sum() / (one**2).sum())
    for pair in wider.tractions:
        assert pair.pressure_difference == pytest.approx(expected, rel=0.01)
        assert 0.02 < pair.shear_difference < 0.2


def test_histories_and_notes_of_two_cylinders(wider: Comparison) -> None:
    found = {(each.quantity, each.edge): each for each in wider.histories}
    assert {each.common for each in wider.histories} == {21}
    assert found["P", ""].difference < 1e-9
    assert found["K_T", "left"].difference == pytest.approx(1 - 1.2**-0.25, abs=5e-4)
    assert wider.notes == ("geometry.parameters.upper_radius: 50.0 and 60.0",)


def test_a_result_agrees_with_itself() -> None:
    comparison = fretfe.compare(solved("halfplane"), solved("halfplane"))
    assert {each.difference for each in comparison.quantities} == {0.0}
    bars = [each for each in comparison.quantities if math.isfinite(each.first_spread)]
    assert len(bars) == 10 and all(each.verdict == "agrees" for each in bars)
    assert all(
        each.pressure_difference == each.shear_difference == 0 for each in comparison.tractions
    )
    assert comparison.notes == ()


def test_closed_forms_agree_within_the_bars() -> None:
    exact = replace(solved("halfplane"), contacts=(closed_contact(solved("halfplane").case),))
    comparison = fretfe.compare(solved("halfplane"), exact)
    edges = [
        each for each in comparison.quantities if each.edge and each.quantity != "friction work"
    ]
    assert len(edges) == 8 and all(each.verdict == "agrees" for each in edges)


def test_other_steps_have_common_times_only() -> None:
    finer = run("halfplane", loads={"press": press(), "shear": shear(steps=12)})
    comparison = fretfe.compare(solved("halfplane"), finer)
    # Pressing, and quarters of both periods.
    assert {each.common for each in comparison.histories} == {4 + 1 + 8}
    assert max(each.difference for each in comparison.histories) < 1e-6
    assert "loads.shear.history.2.steps_per_cycle: 8 and 12" in comparison.notes


def test_extremes_are_told_by_their_load_not_their_time() -> None:
    turned = run(loads={"press": press(), "shear": shear(steps=8, phase=180.0)})
    comparison = fretfe.compare(solved("halfplane"), turned)
    for pair in comparison.tractions:
        assert pair.first.time != pair.second.time
        assert pair.shear_difference < 1e-3


def test_other_names_are_said() -> None:
    case = pad(loads=LOADS)
    case["contacts"] = {"flank": case["contacts"]["main"]}
    comparison = fretfe.compare(solved("halfplane"), fretfe.run(parse_case(case), "halfplane"))
    assert comparison.contacts == (("main", "flank"),)
    (text,) = (note for note in comparison.notes if "compared with" in note)
    assert text == "contact main is compared with flank: each result has one contact only"


def test_contacts_without_partner_are_said() -> None:
    result = solid_result({"main": surface(), "second": surface()})
    comparison = fretfe.compare(result, solid_result({"main": surface()}))
    assert comparison.contacts == (("main", "main"),)
    assert "contact second is in the first result only" in comparison.notes
    assert numbers(comparison)["", "P"].difference == 0
    with pytest.raises(CaseError, match="found main, second and other"):
        fretfe.compare(result, solid_result({"other": surface()}))


def moved(shape: Surface, x: float) -> Surface:
    return replace(shape, points=shape.points + np.array([x, 0.0, 0.0]))


def test_tractions_of_solids_on_other_meshes() -> None:
    """Against integrals of the difference of two Hertz pressures and shears, 0.2 apart."""
    first = solid_result({"main": surface()})
    near = solid_result({"main": moved(surface(corners=4, count=45), 0.2)})
    comparison = fretfe.compare(first, near)
    assert [each.extreme for each in comparison.tractions] == ["largest Q", "smallest Q"]
    line = np.linspace(-1.5, 1.5, 601)
    x, z = np.meshgrid(line, line)
    radii = np.hypot(x, z), np.hypot(x - 0.2, z)
    p, other_p = (hertz(each, 1.0) for each in radii)
    q, other_q = (mindlin(each, SHEAR)[0] for each in radii)
    size = math.sqrt((p**2).sum())
    for pair in comparison.tractions:
        # Linear between nodes 1/12 and 1/15 apart.
        expected = math.sqrt(((other_p - p) ** 2).sum()) / size
        assert pair.pressure_difference == pytest.approx(expected, rel=0.03)
        expected = math.sqrt(((other_q - q) ** 2).sum()) / (FRICTION * size)
        assert pair.shear_difference == pytest.approx(expected, rel=0.06)
        sign = 1.0 if pair.extreme.startswith("largest") else -1.0
        for curve, x_middle in ((pair.first, 0.0), (pair.second, 0.2)):
            radius = np.abs(curve.x - x_middle)
            inner = radius < 0.85
            np.testing.assert_allclose(curve.pressure[inner], hertz(radius, 1.0)[inner], rtol=0.03)
            expected_q = sign * mindlin(radius, SHEAR)[0]
            np.testing.assert_allclose(curve.shear, expected_q, atol=0.2 * np.abs(expected_q).max())
    assert len(fretfe.plot_comparison(comparison)) == 2


@pytest.mark.parametrize("bend", [0.0, 0.3])
def test_solids_agree_with_themselves_and_with_a_finer_mesh(bend: float) -> None:
    first = solid_result({"main": surface(bend)})
    finer = solid_result({"main": surface(bend, count=54)})
    # Chords of an element h miss roots at the front and at the border of stick, c of the radius:
    # the integral of (√s - s/√h)² is h²/30.
    chords = math.sqrt(4 / 15 * (1 + (1 - SHEAR) ** (2 / 3))) * 3.0 / 54
    for other, most in ((first, 1e-12), (finer, chords)):
        comparison = fretfe.compare(first, other)
        assert len(comparison.tractions) == 2
        for pair in comparison.tractions:
            assert max(pair.pressure_difference, pair.shear_difference) < most
        found = {(each.quantity, each.edge): each.difference for each in comparison.histories}
        assert set(found) == {(name, "") for name in ("P", "Q", "area")}
        assert max(found.values()) < max(most, 1e-12)


def test_solids_pressed_up_to_their_ends() -> None:
    """Ends of the other mesh lie within those of the first one by a small part of an element."""
    whole = surface(half=0.5)
    within = replace(whole, points=(1 - 1e-5) * whole.points)
    comparison = fretfe.compare(solid_result({"main": whole}), solid_result({"main": within}))
    assert len(comparison.tractions) == 2
    for pair in comparison.tractions:
        assert max(pair.pressure_difference, pair.shear_difference) < 1e-4


def test_solids_whose_tractions_cannot_be_subtracted() -> None:
    first = solid_result({"main": surface()})
    away = fretfe.compare(first, solid_result({"main": moved(surface(), 5.0)}))
    assert "contact main has other places in the two: p and q are not subtracted" in away.notes
    assert all(math.isnan(each.shear_difference) for each in away.tractions)
    round_one = solid_result({"main": surface(bend=1.2)})
    comparison = fretfe.compare(round_one, round_one)
    assert comparison.tractions == ()
    assert any("expected a surface within 90° of its mean" in note for note in comparison.notes)


def test_histories_of_the_worst_stations_of_solids() -> None:
    """A station's K beside that of the nearest one, along the direction of the first."""
    result = stationed_sphere()
    load = SHEAR * np.sin(result.loads.times)
    first = with_stations(result, lambda each: exact_station(each, load, 89.0))
    second = with_stations(result, lambda each: exact_station(each, -0.9 * load, -89.0))
    (pair,) = (each for each in fretfe.compare(first, second).histories if each.quantity == "K")
    assert pair.edge == "front 1"
    # The directions differ by 2 degrees the other way round.
    assert pair.difference == pytest.approx(1 - 0.9 * math.cos(math.radians(2)))
    far = with_stations(second, lambda each: replace(each, point=each.point + 1.0))
    unknown = with_stations(first, lambda each: replace(each, k_range_spread=math.nan))
    for comparison in (fretfe.compare(first, far), fretfe.compare(unknown, second)):
        assert {each.quantity for each in comparison.histories} == {"P", "Q", "area"}


def test_fronts_are_paired_by_place_whatever_their_numbers() -> None:
    """Fronts of nearly the same length swap their numbers between meshes; ΔK 1 and 1.74."""
    one, two, far = two_fronts(1.0), two_fronts(1.0005), two_fronts(1.0)
    (contact,) = two.contacts
    small, large = contact.fronts
    swapped = (named(large, "front 1"), named(small, "front 2"))
    comparison = fretfe.compare(one, with_fronts(two, *swapped))
    for edge in ("front 1", "front 2"):
        for quantity in ("mean K_N", "mean ΔK"):
            assert numbers(comparison)[edge, quantity].difference == pytest.approx(5e-4)
    assert {each.edge for each in comparison.histories} == {"", "front 1", "front 2"}
    assert max(each.difference for each in comparison.histories) == pytest.approx(5e-4)
    assert (
        "main front 1 is compared with front 2 of the second result, which is in its place"
        in comparison.notes
    )
    missing = fretfe.compare(one, with_fronts(far, named(large, "front 1")))
    assert {edge for edge, _ in numbers(missing)} == {"", "front 2"}
    text = "main front 1 of the first result has no partner: no front of the other one is in its "
    assert text + "place" in missing.notes


def two_fronts(factor: float) -> Result:
    """Two circles of radius 1, 3 apart, all factors of the second one 1.74 times as large."""
    result = stationed_sphere()
    load = SHEAR * np.sin(result.loads.times)
    near = with_stations(result, lambda each: exact_station(each, factor * load, 0.0))
    more = with_stations(result, lambda each: exact_station(each, 1.74 * factor * load, 0.0))
    away = with_stations(more, lambda each: replace(each, point=each.point + np.array([3.0, 0, 0])))
    (one,), (two,) = (each.contacts[0].fronts for each in (near, away))
    fronts = (with_k_n(one, factor), named(with_k_n(two, 1.74 * factor), "front 2"))
    return with_fronts(result, *fronts)


def with_k_n(front: Front, factor: float) -> Front:
    stations = tuple(
        replace(each, k_n=factor * each.k_n, k_n_spread=factor * each.k_n_spread)
        for each in front.stations
    )
    return replace(front, stations=stations)


def named(front: Front, name: str) -> Front:
    stations = tuple(replace(each, front=name) for each in front.stations)
    return replace(front, name=name, stations=stations)


def with_fronts(result: Result, *fronts: Front) -> Result:
    (contact,) = result.contacts
    return replace(result, contacts=(replace(contact, fronts=fronts),))


def test_patches_are_paired_by_place_whatever_their_numbers() -> None:
    """Patches are numbered as they appear: what appears first may be the other one."""
    result = solved("halfplane")
    (left,) = result.contacts
    right = replace(left, centre=left.centre + 5.0, normal_force=2 * left.normal_force)

    def patches(*contacts: Contact) -> Result:
        named = (replace(c, name=f"main[{n}]") for n, c in enumerate(contacts, start=1))
        return replace(result, contacts=tuple(named))

    comparison = fretfe.compare(patches(left, right), patches(right, left))
    assert comparison.contacts == (("main[1]", "main[2]"), ("main[2]", "main[1]"))
    assert {each.difference for each in comparison.histories if each.quantity == "P"} == {0.0}
    assert "contact main[1] is compared with main[2], which is in its place" in comparison.notes
    alone = fretfe.compare(patches(left, right), patches(right))
    assert alone.contacts == (("main[2]", "main[1]"),)
    assert "contact main[1] is in the first result only" in alone.notes


def test_factors_that_are_known_from_other_times_on_are_counted_alike() -> None:
    """A sum of increments that starts later differs by what it was then."""
    result = stationed_sphere()
    load = SHEAR * np.sin(result.loads.times)
    start = len(load) // 3
    late = np.where(np.arange(len(load)) < start, math.nan, load - load[start])
    first = with_stations(result, lambda each: exact_station(each, load, 0.0))
    second = with_stations(result, lambda each: exact_station(each, late, 0.0))
    second = with_stations(second, lambda each: replace(each, k_range_spread=0.1))
    comparison = fretfe.compare(first, second)
    (pair,) = (each for each in comparison.histories if each.quantity == "K")
    assert pair.common == len(load) - start
    assert pair.difference < 1e-12
    time = f"{result.loads.times[start]:g}"
    assert f"main front 1: K over time is compared from t = {time} on, since when both know it" in (
        comparison.notes
    )


def test_histories_without_contact_at_first_are_printed(capsys: pytest.CaptureFixture[str]) -> None:
    result = solved("halfplane")
    comparison = fretfe.compare(result, result)
    (pair, *_) = (each for each in comparison.histories if each.quantity == "K_T")
    largest = np.abs(pair.first[1:]).max()
    open_first = replace(pair, first=np.append(math.nan, pair.first[1:]))
    _print_comparison(replace(comparison, histories=(open_first,)))
    text = " ".join(capsys.readouterr().out.split())
    assert f"K_T over time ({number(float(largest))} MPa" in text


def test_extremes_of_other_kinds_are_said() -> None:
    """Without shear K_I takes the place of K_T."""
    pressed = run(loads={"press": press(force=500.0, steps=2)})
    comparison = fretfe.compare(solved("halfplane"), pressed)
    assert comparison.tractions == ()
    assert any("its load extremes are of other kinds" in note for note in comparison.notes)


def test_half_cycles_of_other_times_are_said() -> None:
    comparison = fretfe.compare(solved("halfplane"), solved("no cycle"))
    assert "main left: the last slip zones end at t = 2.75 and t = 2" in comparison.notes
    assert numbers(comparison)["left", "ΔK_T"].verdict == "unknown"


def test_a_run_that_ended_early_says_so() -> None:
    ended = replace(solved("halfplane"), failure=ConvergenceError("step 12 did not converge"))
    comparison = fretfe.compare(solved("halfplane"), ended)
    assert "the second run is not complete: step 12 did not converge" in comparison.notes


def test_what_cannot_be_compared_is_refused() -> None:
    with pytest.raises(CaseError, match="found plane bodies and solids"):
        fretfe.compare(solved("halfplane"), solid_result({"main": surface()}))
    with pytest.raises(CaseError, match="found mm, N, MPa, s and mm, N, MPa, h"):
        fretfe.compare(solved("halfplane"), run("halfplane", units={"time": "h"}))


def test_bars_of_a_difference() -> None:
    pair = QuantityPair("main", "left", "K_N", "", 100.0, 104.0, 3.0, 2.0)
    assert pair.difference == pytest.approx(0.04)
    # 104/100·3 % and 2 %.
    assert pair.difference_spread == pytest.approx(math.hypot(0.0312, 0.02))
    assert pair.verdict == "differs"
    unknown = QuantityPair("main", "left", "K_N", "", math.nan, 104.0, 3.0, 2.0)
    assert unknown.verdict == "unknown"
    assert QuantityPair("main", "left", "ΔK_T", "", 0.0, 0.0, 0.0, 0.0).verdict == "unknown"


@pytest.mark.pictures
def test_command(tmp_path: Path) -> None:
    one, two = (write_run(tmp_path / name, "halfplane") for name in ("one", "two"))
    done = command("compare", one, two, "-o", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    text = " ".join(done.stdout.split())
    assert "main left K_N [MPa/√mm]" in text and "one two difference" in text
    assert "p differs by 0.00%, q by 0.00% of f p" in text
    written = json.loads((tmp_path / "out" / "comparison.json").read_text("utf-8"))
    assert written["schema"] == {"name": "fretfe-comparison", "version": 2}
    assert written["contacts"] == [["main", "main"]]
    pictures = {path.name for path in (tmp_path / "out").glob("*.png")}
    assert pictures == {"differences.png", "tractions.png", "histories.png"}
    printed = command("compare", one, two, "--json")
    assert json.loads(printed.stdout) == written


def test_a_folder_of_results_is_refused(tmp_path: Path) -> None:
    one = write_run(tmp_path / "one", "halfplane")
    done = command("compare", one, one, "-o", one)
    assert done.returncode == 2 and "expected a folder without results of a run" in done.stderr
