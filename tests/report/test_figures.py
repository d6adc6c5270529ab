# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the plots of the report draw: asymptotes, loops and states, against closed forms."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cases.stored_runs import write_run
from harness.plots import tick_numbers, whole_plots
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe.analytic.partial_slip import hertz_dissipation
from fretfe.analytic.profiles import Hertz, composite_modulus
from fretfe.history.solution import OPEN, STICK
from fretfe.report import theme
from fretfe.report.figures.edges import _draw, _near, _stuck_change
from fretfe.report.figures.history import (
    _middle,
    _tension_varies,
    draw_factors,
    draw_loads,
    loop_area,
    rows_of,
    without_slope,
    work_loop_plots,
)
from fretfe.report.figures.tractions import _limits, _status_map, slip_plot
from fretfe.report.page.tables import edge_answers
from fretfe.report.source import Shown, shown_contacts
from fretfe.report.texts import number, percent, with_error
from fretfe.report.theme import make_plot
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.writer import kept_states

P, Q, FRICTION = 600.0, 60.0, 0.4
PROFILE = Hertz(50.0, composite_modulus(210e3, 0.3, 210e3, 0.3))


@pytest.fixture(scope="module", autouse=True)
def whole() -> Iterator[None]:
    with whole_plots():
        yield


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Result:
    return load_result(write_run(tmp_path_factory.mktemp("cycle"), "halfplane"))


@pytest.fixture(scope="module")
def shown(run: Result) -> Shown:
    return shown_contacts(run)[0]


@pytest.mark.parametrize("side", [0, 1], ids=["left", "right"])
def test_change_of_the_stuck_contact_is_that_of_the_closed_form(shown: Shown, side: int) -> None:
    """2 Q/(pi sqrt(a^2 - x^2)) between Q and -Q, positive in the sense of ΔK_T at both edges."""
    near = _near(shown, shown.summary.stations[side])
    assert near is not None
    solution = shown.run.solution
    change = _stuck_change(solution, shown, near)
    assert change is not None
    a = float(PROFILE.half_width(P))
    x = shown.tractions.surface.arc
    inside = np.abs(x) < 0.9 * a
    exact = 2 * Q / (np.pi * np.sqrt(a**2 - x[inside] ** 2))
    # 300 elements over the contact; nodal values of a singular field.
    np.testing.assert_allclose(change[inside] @ near.line, exact, rtol=0.01)
    # ΔK_T of eq. (7); its asymptote is met near the edge to s/(4a).
    assert near.range == pytest.approx(2 * Q / (np.pi * np.sqrt(2 * a)), rel=5e-3)


def test_states_that_are_compared_are_reversals_in_which_the_change_meets_the_bound(
    shown: Shown,
) -> None:
    edge = shown.summary.stations[0]
    near, zone = _near(shown, edge), edge.longest_zone
    assert near is not None and zone is not None
    states = [near.earlier, near.later]
    np.testing.assert_allclose(np.abs(shown.summary.shear_force[states]), Q, rtol=1e-6)
    figure = Figure()
    _draw(figure, shown, near)
    lines = {str(line.get_label()): np.array(line.get_data()) for line in figure.axes[1].lines}
    assert lines["d found"][0] == pytest.approx(zone.length)
    (s, change), (_, bound) = lines["change of q"], lines["friction bound"]
    slips, sticks = s < 0.8 * zone.length, s > 1.2 * zone.length
    assert slips.sum() > 3
    np.testing.assert_allclose(change[slips], bound[slips], rtol=1e-6)
    assert (change[sticks] < bound[sticks]).all()


@pytest.mark.parametrize("which", [-1, -2])
def test_the_half_cycle_next_to_an_edge_is_that_of_the_first_lines(run: Result, which: int) -> None:
    """Zones of both half cycles differ where P varies; either may be the longer one."""
    (contact,) = run.contacts
    edge = contact.stations[0]
    zones = list(edge.slip_zones)
    zones[which] = replace(zones[which], length=1.5 * zones[which].length)
    edge = replace(edge, slip_zones=tuple(zones), k_range=1.1 * edge.k_range)
    fronts = (replace(contact.fronts[0], stations=(edge,)), contact.fronts[1])
    other = replace(run, contacts=(replace(contact, fronts=fronts),))
    (shown,) = shown_contacts(other)
    near, worst = _near(shown, edge), other.headline.worst
    assert near is not None and worst is not None and worst.zone is not None
    assert worst.name == "main.left"
    told = worst.zone
    assert (near.earlier, near.later, zones[which].length) == (told.start, told.end, told.length)
    marked = [answer[2] for answer in edge_answers(other)]
    assert [zone.told for zones in marked for zone in zones] == [
        which == -2,
        which == -1,
        False,
        False,
    ]
    few = run.case.output.model_copy(update={"tractions": "extremes"})
    other = replace(other, case=run.case.model_copy(update={"output": few}))
    assert {told.start, told.end} <= set(kept_states(other, other.solution).tolist())


def test_without_a_cycle_first_loading_is_compared(tmp_path: Path) -> None:
    run = load_result(write_run(tmp_path, "no cycle"))
    (shown,) = shown_contacts(run)
    near = _near(shown, shown.summary.stations[0])
    assert near is not None
    times = run.loads.times
    # Friction begins at 1, where the shear begins too.
    assert (times[near.earlier], times[near.later]) == (1.0, 2.0)
    assert work_loop_plots(run) == []


def test_area_of_a_loop_survives_the_change_of_its_slope() -> None:
    angle = np.linspace(0, 2 * np.pi, 200)
    force, displacement = 3 + 2 * np.sin(angle), 5 * np.sin(angle - 0.1) + 7
    # pi times both amplitudes times the sine of the phase; 200 corners for a smooth loop.
    assert loop_area(force, displacement) == pytest.approx(np.pi * 10 * np.sin(0.1), rel=1e-3)
    reduced = without_slope(force, displacement)
    assert loop_area(force, reduced) == pytest.approx(loop_area(force, displacement), rel=1e-9)
    # What is left is narrow: 5 sin(0.1).
    assert np.abs(reduced).max() == pytest.approx(5 * np.sin(0.1), rel=1e-2)


def test_loop_at_constant_force_keeps_its_displacement() -> None:
    displacement = np.array([0.0, 1.0, 2.0])
    np.testing.assert_allclose(without_slope(np.full(3, 4.0), displacement), displacement - 1.0)
    assert loop_area(np.full(3, 4.0), displacement) == pytest.approx(8.0)


def test_loop_of_the_boundary_has_the_area_of_the_friction_work(run: Result) -> None:
    (plot,) = work_loop_plots(run)
    exact = float(hertz_dissipation(PROFILE, P, FRICTION, Q))
    found = [float(each) for each in re.findall(r": ([0-9.e-]+[0-9])", plot.caption)]
    # Area of this loop, of all loops, friction work: 8 steps for the cycle.
    assert found == pytest.approx([exact] * 3, rel=0.15)
    assert found[0] == found[1]
    assert "equal up to the size of the load steps" in plot.caption


@pytest.mark.parametrize(
    ("values", "middle"),
    [([-0.0192966, -0.0192964], -0.0193), ([0.0, 1e-3], 0.0), ([2.0, 2.1], 0.0), ([0.0, 0.0], 0.0)],
)
def test_middle_of_values_that_hardly_differ(values: list[float], middle: float) -> None:
    assert _middle(np.array(values)) == middle


def test_ticks_of_a_boundary_whose_force_is_held(
    run: Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They differ, although its displacement hardly does."""
    solution, figures = run.solution, []
    forces, amplitudes = np.array(solution.forces), np.array(solution.amplitudes)
    forces[:, 0] = -2900.0
    amplitudes[:, 0] = -0.01929655 + 1e-7 * np.sin(2 * np.pi * run.loads.times)

    def keep(figure: Figure, key: str) -> str:
        figures.append(figure)
        return "<svg></svg>"

    monkeypatch.setattr(theme, "_svg", keep)
    work_loop_plots(
        replace(run, root_solution=replace(solution, forces=forces, amplitudes=amplitudes))
    )
    left, _ = figures[0].axes
    figures[0].draw_without_rendering()
    ticks = tick_numbers(left, "x")
    assert len(set(ticks)) == len(ticks) > 2
    assert left.get_xlabel() == "displacement [nm]\nplus 0.0193 mm"
    assert tick_numbers(left, "y") == ["-2900"]


def test_tension_of_round_off_is_not_shown(run: Result) -> None:
    contact = run.contacts[0]
    assert not _tension_varies(run, contact)


def test_map_has_pixels_and_both_directions_of_slip(shown: Shown) -> None:
    plot = slip_plot(shown)
    assert plot.svg.count("data:image/png;base64,") == 3
    # Their colours stand in the legend as paths.
    assert all(colour in plot.svg for colour in ("#56b4e9", "#d55e00"))


def test_a_contact_that_carries_nothing_is_open_in_the_map(shown: Shown) -> None:
    """Unloaded surfaces that touch were drawn slipping, towards larger x at both flanks."""
    force = np.where(np.arange(len(shown.summary.normal_force)) < 3, 1e-9, 1.0)
    idle = replace(shown, summary=replace(shown.summary, normal_force=force))
    axes = Figure().subplots()
    _status_map(axes, idle, -1.0, 1.0, (0, 6))
    (mesh,) = axes.collections
    kinds = np.asarray(mesh.get_array())
    assert (kinds[:2] == OPEN).all() and (kinds[2:] != OPEN).any(axis=1).all()


def texts(axes: Axes) -> list[str]:
    return [each.get_text() for each in axes.texts]


def test_names_of_loads_stand_above_their_panels_and_ticks_are_plain_numbers(run: Result) -> None:
    """A load that is held has no ticks but 0; no factor stands aside."""
    values = np.stack([0 * run.loads.times, 2.5e5 * run.loads.times], axis=1)
    loads = {f"{key}_of_a_long_name": run.case.loads["press"] for key in ("held", "ramp")}
    case = run.case.model_copy(update={"loads": loads})
    figure = Figure()
    history = replace(run.loads, channels=tuple(loads), values=values)
    draw_loads(rows_of(figure, 2), case, history)
    figure.draw_without_rendering()
    held, ramp = figure.axes
    assert [each.get_title(loc="left") for each in figure.axes] == [*loads]
    assert [each.get_ylabel() for each in figure.axes] == ["[N]", "[N]"]
    assert tick_numbers(held, "y") == ["0"]
    assert ramp.yaxis.get_offset_text().get_text() == ""
    assert "200000" in tick_numbers(ramp, "y")


@pytest.mark.parametrize("known", [("left", "right"), ("left",), ()], ids=str)
@pytest.mark.parametrize("first", [0.0, np.nan])
def test_factors_that_are_unknown_are_said_to_be(
    run: Result, known: tuple[str, ...], first: float
) -> None:
    """The state from which they are counted has 0, if there is any."""
    (contact,) = run.contacts
    lost = np.where(np.arange(len(run.loads.times)) == 5, first, np.nan)
    fronts = tuple(
        front
        if front.name in known
        else replace(
            front, stations=tuple(replace(each, k_t=lost, k_n=lost) for each in front.stations)
        )
        for front in contact.fronts
    )
    figure = Figure()
    draw_factors(rows_of(figure, 2), run.case, run.loads, (replace(contact, fronts=fronts),))
    figure.draw_without_rendering()
    labels = figure.axes[0].get_legend_handles_labels()[1]
    assert [label.endswith(", unknown") for label in labels] == [
        side not in known for side in ("left", "right")
    ]
    for axes in figure.axes:
        assert ("unknown: the warnings say why" in texts(axes)) != bool(known)
        assert bool(tick_numbers(axes, "y")) == bool(known)


def test_a_contact_of_one_node_has_room_around_it(shown: Shown) -> None:
    status = np.full(shown.tractions.status.shape, OPEN)
    status[:, 7] = STICK
    alone = replace(shown, tractions=replace(shown.tractions, status=status))
    low, high = _limits(alone, np.array([np.nan]))
    place, arc = shown.tractions.surface.arc[7], shown.tractions.surface.arc
    assert low < place < high and high - low == pytest.approx(0.08 * np.ptp(arc), rel=0.5)


def draw(figure: Figure) -> None:
    axes = figure.subplots()
    axes.plot([0.12345678, 1.0], [0.0, 1.0], marker="o")
    axes.set_title("$x_1$ <b>")


def test_drawings_have_ids_and_glyphs_of_their_own() -> None:
    one, other = (make_plot(key, "t", "c", 2.0, draw).svg for key in ("one", "other"))
    names = [set(re.findall(r'\bid="([^"]*)"', svg)) for svg in (one, other)]
    assert names[0] and not names[0] & names[1]
    for svg, ids in zip((one, other), names, strict=True):
        used = set(re.findall(r'(?:href="|url\()#([^")]*)', svg))
        assert used and used <= ids
        assert svg.startswith("<svg") and svg.endswith("</svg>")
        assert not re.search(r"<(metadata|style|\?xml|!)", svg)
    assert one == make_plot("one", "t", "c", 2.0, draw).svg


def test_drawings_are_no_wider_than_a_column() -> None:
    svg = make_plot("one", "t", "c", 2.0, draw).svg
    width = re.search(r'width="([0-9.]+)pt"', svg)
    # 72 points an inch.
    assert width is not None and float(width[1]) == pytest.approx(3.7 * 72)
    assert "viewBox" in svg


def test_names_with_dollar_signs_and_foreign_letters_are_drawn() -> None:
    def strange(figure: Figure) -> None:
        figure.subplots().set_xlabel("$\\frac{$ 接触 [x_1]")

    assert "<svg" in make_plot("strange", "t", "c", 2.0, strange).svg


@pytest.mark.parametrize(
    ("value", "text"),
    [(1239.2345, "1239"), (-0.0, "0"), (1e-13, "1e-13"), (np.nan, "-"), (np.inf, "-")],
)
def test_numbers(value: float, text: str) -> None:
    assert number(value) == text


@pytest.mark.parametrize(
    ("value", "spread", "text"),
    [
        (3266.6487, 43.4, "3267 ± 43"),
        (52.599055, 0.0388, "52.599 ± 0.039"),
        (0.57491, np.nan, "0.57491"),
        (35.6078, 0.0, "35.6078"),
        (1.23456e-11, 2.5e-13, "1.23456e-11 ± 2.5e-13"),
        (np.nan, 1.0, "-"),
    ],
)
def test_numbers_with_errors(value: float, spread: float, text: str) -> None:
    assert with_error(value, spread) == text


def test_fractions() -> None:
    assert (percent(0.0123), percent(np.inf)) == ("1.23%", "-")
