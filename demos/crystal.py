# SPDX-License-Identifier: LGPL-3.0-or-later
"""A single-crystal firtree in a polycrystalline disc: what the orientation of the crystal changes.

The crystal is turned about the axis of the engine, which is one of its ⟨001⟩ axes. Known is that a
quarter of a turn changes nothing; that an angle does to the left flanks what the angle up to a
quarter does to the right ones; and that half-planes of the crystal do not feel the angle at all:
what the factors do feel comes from the stiffness of the lobes and the neck. The shear stress on the
slip systems of the crystal changes as well.

Then it is turned about the axis of the blade, by its secondary angle. Displacements along the
engine's axis come in, with K_S: known is that an angle and the angle up to a quarter of a turn are
mirror images, with equal K_N, |ΔK| and shear stress on the slip systems, and opposite K_S.

Run it with: python demos/crystal.py [FIGURE.png]
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from compare import Row, finish
from matplotlib.figure import Figure

import fretfe
from fretfe.materials.moduli import normal_modulus
from fretfe.results.model import Result
from fretfe.runner import Runner

ANGLES = [0.0, 30.0, 60.0, 90.0]
SECONDARY = [15.0, 30.0, 45.0, 60.0]
FLANKS = ("left_1", "left_2", "right_1", "right_2")
FLANK_ANGLE = math.radians(45.0)
# Outward normal of the right flanks of the blade.
NORMAL = np.array([math.sin(FLANK_ANGLE), math.cos(FLANK_ANGLE)])
# Normals of {111} and directions <110> that lie in each of them.
PLANES = np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1], [1, 1, -1]])
DIRECTIONS = np.array([[1, 1, 0], [1, -1, 0], [1, 0, 1], [1, 0, -1], [0, 1, 1], [0, 1, -1]])


def about_engine(angle: float) -> np.ndarray:
    """Axes of the crystal, turned about z."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def about_blade(angle: float) -> np.ndarray:
    """Axes of the crystal, turned about y."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def resolved_shear(stress: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """(N,) largest range on the octahedral systems of stresses (T, N, 4 or 6)."""
    xx, yy, zz, xy, *out = np.moveaxis(stress, -1, 0)
    yz, xz = out or np.zeros((2, *xx.shape))
    rows = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    tensor = np.moveaxis(np.array(rows), (0, 1), (-2, -1))
    ranges = [
        np.ptp(tensor @ (b @ axes) @ (n @ axes), axis=0) / math.sqrt(6)
        for n in PLANES
        for b in DIRECTIONS
        if n @ b == 0
    ]
    return np.max(ranges, axis=0)


def solve(folder: Path) -> dict[float, Result]:
    """The result of each angle about the axis of the engine."""
    return {
        angle: run({"bodies.blade.orientation.euler": [angle, 0.0, 0.0]}, folder / f"{angle:g}")
        for angle in ANGLES
    }


def solve_secondary(folder: Path) -> dict[float, Result]:
    """The result of each angle about the axis of the blade."""
    held = {"supports.rim.fix": ["x", "y", "z"]}
    return {
        angle: run(
            {**held, "bodies.blade.orientation.euler": [90.0, angle, -90.0]},
            folder / f"secondary-{angle:g}",
        )
        for angle in SECONDARY
    }


def run(values: dict[str, Any], folder: Path) -> Result:
    """The case with other values, as fretfe.run but without a report."""
    case = fretfe.load_case(Path(__file__).with_suffix(".toml"), values)
    return Runner.find("fem").run(case, folder)


def carried(result: Result) -> np.ndarray:
    """(T,) pull that all flanks carry."""
    total = np.zeros(len(result.loads.values))
    for each in result.contacts:
        # The shear of a right flank is positive towards its upper end, that of a left one negative.
        side = 1.0 if "right" in each.name else -1.0
        total += math.cos(FLANK_ANGLE) * each.normal_force
        total += side * math.sin(FLANK_ANGLE) * each.shear_force
    return total


def largest_shear(result: Result, flank: str) -> float:
    """Largest range of resolved shear stress in the blade below a flank."""
    return float(np.nanmax(result.stress_parameters(flank)[0].octahedral_shear))


def rows_of(results: dict[float, Result]) -> Iterator[Row]:
    """All that is known of the sweep."""
    first = normal_modulus(results[0.0].case.bodies["blade"], "strain", NORMAL)
    for angle, result in results.items():
        pull = result.loads.values[:, 0]
        yield Row(f"{angle:g}°: pull [N/mm]", carried(result).max(), pull.max(), 1e-8)
        modulus = normal_modulus(result.case.bodies["blade"], "strain", NORMAL)
        yield Row(f"{angle:g}°: 2/A_n of a flank, as at 0° [MPa]", modulus, first, 1e-9)
        yield shear_row(result, f"{angle:g}°", about_engine(angle))
    yield from same_edges(results, 0.0, {name: name for name in FLANKS}, 1e-6)
    # The mesh mirrors itself to 1e-6.
    yield from same_edges(results, 30.0, {f"right_{i}": f"left_{i}" for i in "12"}, 1e-3)


def shear_row(result: Result, label: str, axes: np.ndarray) -> Row:
    """Resolved shear below a flank, from its stress."""
    stress = result.stress_history("right_1").bodies[0].stress[:, 0]
    by_hand = float(np.nanmax(resolved_shear(stress, axes)))
    found = largest_shear(result, "right_1")
    return Row(f"{label}: resolved shear, by hand [MPa]", found, by_hand, 1e-9)


def same_edges(
    results: dict[float, Result], angle: float, flanks: dict[str, str], tolerance: float
) -> Iterator[Row]:
    """Factors at an angle, and those at the angle up to 90°, of the same or mirrored flanks."""
    one, other = (
        {each.name: each.stations for each in results[number].contacts}
        for number in (angle, 90 - angle)
    )
    for name, second in flanks.items():
        step = 1 if name == second else -1
        for edge, twin in zip(one[name], other[second][::step], strict=True):
            label = f"{name} {edge.front} at {angle:g}°, {90 - angle:g}°"
            yield Row(f"K_N {label}", edge.k_n[-1], twin.k_n[-1], tolerance)
            yield Row(f"ΔK_T {label}", edge.k_t_range, twin.k_t_range, tolerance)


def secondary_rows(results: dict[float, Result]) -> Iterator[Row]:
    """Mirror images: 30° and 60° about the axis of the blade."""
    for angle, result in results.items():
        yield shear_row(result, f"secondary {angle:g}°", about_blade(angle))
    for flank in FLANKS:
        label = f"resolved shear below {flank}, secondary 30°, 60° [MPa]"
        yield Row(label, *(largest_shear(results[angle], flank) for angle in (30.0, 60.0)), 1e-6)
    one, other = (
        [(each.name, station) for each in results[angle].contacts for station in each.stations]
        for angle in (30.0, 60.0)
    )
    for (name, edge), (_, twin) in zip(one, other, strict=True):
        label = f"{name} {edge.front}, secondary 30°, 60°"
        yield Row(f"K_N {label}", edge.k_n[-1], twin.k_n[-1], 1e-6)
        yield Row(f"|ΔK| {label}", edge.k_range, twin.k_range, 1e-6)
        yield Row(f"K_S, all of the history, {label}", np.ptp(edge.k_s), np.ptp(twin.k_s), 1e-6)
        yield Row(f"direction of ΔK {label} [°]", edge.k_angle, -twin.k_angle, 1e-6)


def draw(results: dict[float, Result], secondary: dict[float, Result], path: Path) -> None:
    """Factors of the right flanks and resolved shear below them, over both angles."""
    figure = Figure(figsize=(11.0, 7.0), layout="constrained")
    upper, lower = figure.subplots(2, 3)
    draw_factors(upper, results, {"K_N [MPa/√mm]": "k_n", "ΔK_T [MPa·√mm]": "k_t_range"})
    turned = {0.0: results[0.0], **secondary}
    draw_factors(lower, turned, {"K_N [MPa/√mm]": "k_n", "|ΔK| [MPa·√mm]": "k_range"})
    for axes, found in ((upper[2], results), (lower[2], turned)):
        axes.set_title("range of resolved shear, .1 mm below [MPa]", fontsize=10)
        for flank in ("right_1", "right_2"):
            values = [largest_shear(result, flank) for result in found.values()]
            axes.plot(list(found), values, ".-", label=f"lobe {flank.removeprefix('right_')}")
        axes.set_xticks(list(found))
    upper[2].legend(fontsize=8)
    for axes in upper:
        axes.set_xlabel("angle about the axis of the engine [°]")
    for axes in lower:
        axes.set_xlabel("secondary angle [°]")
    for axes in (*upper, *lower):
        axes.set_ylim(bottom=0)
    upper[0].legend(fontsize=8)
    figure.savefig(path, dpi=120)


def draw_factors(panels: np.ndarray, results: dict[float, Result], found: dict[str, str]) -> None:
    """Numbers of the edges of the right flanks over the angle."""
    for axes, (label, key) in zip(panels, found.items(), strict=False):
        axes.set_title(label, fontsize=10)
        axes.set_xticks(list(results))
        for flank in ("right_1", "right_2"):
            for number, front in enumerate(("lower", "upper")):
                values = []
                for result in results.values():
                    (contact,) = (each for each in result.contacts if each.name == flank)
                    values.append(np.ravel(getattr(contact.stations[number], key))[-1])
                lobe = flank.removeprefix("right_")
                axes.plot(list(results), values, ".-", label=f"lobe {lobe}, {front} edge")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        solved = solve(Path(name))
        secondary = solve_secondary(Path(name))
        known = [*rows_of(solved), *secondary_rows(secondary)]
        if len(sys.argv) > 1:
            draw(solved, secondary, Path(sys.argv[1]))
    finish(known)
