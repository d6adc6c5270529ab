# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results of solids that no finite elements had to compute: Hertz, and Cattaneo and Mindlin.

A sphere is pressed on a block by P and sheared along x by ±Q. Its contact stands on a surface that
is flat, or bent about the z axis with a radius, or about two axes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import closing
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from cases.pad_cases import pad, press, shear

from fretfe._typing import Array, Indices
from fretfe.case import Case, parse_case
from fretfe.evaluate.contacts import Station
from fretfe.evaluate.evaluate import evaluate
from fretfe.evaluate.space.evaluate import evaluate_fronts
from fretfe.evaluate.space.fronts import follow_fronts
from fretfe.history.solution import OPEN, SLIP, STICK, ContactHistory, FullStickUnits, Solution
from fretfe.loads import build_history
from fretfe.mesh.mesh import BodyMesh
from fretfe.results.field_files import FIELDS, FieldWriter
from fretfe.results.model import Result
from fretfe.results.writer import write_results
from fretfe.surface.contact_surface import ContactSurface
from fretfe.surface.friction import Friction
from fretfe.surface.surface import tangent_frames

# Length of a straight front.
LENGTH = 3.0

FRICTION, RADIUS, PEAK, SHEAR = 0.4, 1.0, 300.0, 0.6
# P of Hertz's pressure.
NORMAL = 2 * np.pi * RADIUS**2 * PEAK / 3
PRESSING, STEPS = 4, 16
# Largest slip at the edge of the contact.
SLIDE = 2e-3
# Of the circle, with a = 1; K of it where it is bonded under Q = f P, f P = 2 π f p0/3.
K_N = PEAK * np.sqrt(2)
LIMIT = FRICTION * PEAK * 2 / 3 / (2 * np.sqrt(2))
CERTIFICATE = (
    "penetration", "adhesion", "open_traction", "closed_gap", "cone", "stuck_drift",
    "slip_with_traction", "dissipation", "worst", "force_imbalance",
    "moment_imbalance",
)  # fmt: skip
SCALES = ("pressure_scale", "gap_scale", "force_scale", "moment_scale")


def solid_case(contacts: Iterable[str] = ("main",), **output: object) -> Case:
    """A pad on a block, as a solid; surfaces of its contacts but the first are not there."""
    loads = {"press": press(steps=PRESSING), "shear": shear(steps=STEPS)}
    tables = pad(loads=loads, output=output)
    tables["geometry"]["solid"] = {"length": 4.0, "layers": 2}
    main = tables["contacts"]["main"]
    for name in set(contacts) - {"main"}:
        surfaces = {key: f"{name}_{key}" for key in ("surface1", "surface2")}
        tables["contacts"][name] = {**main, **surfaces}
    return parse_case(tables)


@dataclass(frozen=True)
class Surface:
    """A rectangle of facets.

    Attributes:
        points: (N, 3) nodes.
        facets: (F, 3 or 4).
        plane: (N, 2) lengths along the surface, x and z.
        normals: (N, 3).
    """

    points: Array
    facets: Indices
    plane: Array
    normals: Array


def surface(bend: float = 0.0, corners: int = 3, half: float = 1.5, count: int = 36) -> Surface:
    """A surface, bent about the z axis with the curvature `bend`; its normal is y in the middle."""
    line = np.linspace(-half, half, count + 1)
    s, z = (each.ravel() for each in np.meshgrid(line, line, indexing="ij"))
    angle = s * bend
    x = np.sin(angle) / bend if bend else s
    y = (np.cos(angle) - 1) / bend if bend else 0 * s
    first = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    # Counter-clockwise seen from +y.
    quads = np.stack([first, first + 1, first + count + 2, first + count + 1], axis=1)
    facets = quads if corners == 4 else np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    normals = np.stack([np.sin(angle), np.cos(angle), 0 * s], axis=1)
    return Surface(np.stack([x, y, z], axis=1), facets, np.stack([s, z], axis=1), normals)


def sphere(radius: float = 3.0) -> Surface:
    """A surface that is bent about both axes."""
    flat = surface()
    x, z = flat.plane.T
    y = np.sqrt(radius**2 - x**2 - z**2)
    points = np.stack([x, y - radius, z], axis=1)
    return Surface(points, flat.facets, flat.plane, np.stack([x, y, z], axis=1) / radius)


def hertz(radius: Array, border: float) -> Array:
    """p of a contact of radius `border` under the same curvature."""
    return PEAK / RADIUS * np.sqrt(np.clip(border**2 - radius**2, 0.0, None))


def mindlin(radius: Array, drop: float) -> tuple[Array, Array]:
    """Shear over its direction, and relative slip, for a change of Q by `drop` f P."""
    border = RADIUS * (1 - drop) ** (1 / 3)
    inside = radius < RADIUS
    slip = SLIDE * np.clip(radius - border, 0.0, None) * inside
    return FRICTION * (hertz(radius, RADIUS) - hertz(radius, border)), slip


def histories(radius: Array, loads: Array) -> dict[str, Array]:
    """Pressure, shear along x, slip along x and status at the nodes for Q over time."""
    pressure, shears, slips, status = [0 * radius], [0 * radius], [0 * radius], [0 * radius]
    top, bottom, shear_top, slip_top = 0.0, 0.0, 0 * radius, 0 * radius
    for number, load in enumerate(loads):
        border = RADIUS * min((number + 1) / PRESSING, 1.0) ** (1 / 3)
        step = load - (loads[number - 1] if number else 0.0)
        rising = step >= 0
        if top == 0.0 and rising:
            shear_now, slip_now = mindlin(radius, load)
            drop = load
        else:
            start = bottom if rising else top
            drop = abs(load - start) / 2
            change, slid = mindlin(radius, drop)
            sign = 1 if rising else -1
            shear_now = (-1 if rising else 1) * shear_top + 2 * sign * change
            slip_now = (-1 if rising else 1) * slip_top + 2 * sign * slid
        if load >= SHEAR * (1 - 1e-9):
            top, bottom = load, -load
            shear_top, slip_top = mindlin(radius, load)
        closed = radius < border
        stick = closed & (radius <= RADIUS * (1 - drop) ** (1 / 3))
        pressure.append(hertz(radius, border))
        shears.append(shear_now * closed)
        slips.append(slip_now)
        status.append(np.where(stick, STICK, np.where(closed, SLIP, OPEN)))
    names = ("pressure", "shear", "slip", "status")
    return dict(zip(names, map(np.array, (pressure, shears, slips, status)), strict=True))


def contact(shape: Surface, name: str, history: dict[str, Array]) -> ContactHistory:
    """A contact that body 2 carries on a surface."""
    frames = tangent_frames(shape.normals)
    count = len(history["pressure"])
    # Facets share their area among their nodes.
    corners = shape.points[shape.facets]
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(sides, axis=1) * (1.0 if shape.facets.shape[1] == 4 else 0.5)
    weights = np.bincount(
        shape.facets.ravel(), np.repeat(size / shape.facets.shape[1], shape.facets.shape[1])
    )
    zero = 0 * history["shear"]
    traction = np.stack([history["pressure"], history["shear"], zero], axis=2)
    slip = np.stack([history["slip"], zero], axis=2)
    moved = np.diff(history["slip"], axis=0, prepend=0.0)
    return ContactHistory(
        name=name, pair=name, body1="upper", body2="lower",
        surface=ContactSurface(
            np.zeros(0), shape.points, frames, weights,
            shape.facets, free=np.zeros(len(weights), dtype=bool),
        ),
        friction=Friction.uniform(np.full(count, FRICTION), len(weights)),
        traction=traction, mean_traction=traction,
        gap=1e-3 * np.clip(np.linalg.norm(shape.plane, axis=1) - RADIUS, 0, None)
        * np.ones((count, 1)),
        slip=slip, status=history["status"].astype(np.int8),
        dissipation=np.abs(moved * history["shear"]) * weights,
        full_stick=FullStickUnits(np.zeros((0, len(weights), 3, 1)), np.full(count, -1)),
    )  # fmt: skip


def solid_result(shapes: dict[str, Surface] | None = None, **output: object) -> Result:
    """A solved case, evaluated."""
    shapes = shapes or {"main": surface(bend=0.3)}
    case = solid_case(shapes, **output)
    loads = build_history(case)
    count = len(loads.times)
    shear_load = loads.values[1:, 1]
    ratio = SHEAR * shear_load / np.abs(shear_load).max()
    contacts = tuple(
        contact(shape, name, histories(np.linalg.norm(shape.plane, axis=1), ratio))
        for name, shape in shapes.items()
    )
    weights = contacts[0].surface.weights
    forces = np.stack([contacts[0].traction[..., 0] @ weights,
                       contacts[0].traction[..., 1] @ weights], axis=1)  # fmt: skip
    amplitudes = np.stack([-1e-5 * forces[:, 0], 1e-5 * forces[:, 1]], axis=1)
    amplitudes[:, 1] += contacts[0].slip[..., 0] @ weights
    certificates = {name: np.full(count, 1e-12) for name in CERTIFICATE}
    certificates |= {name: np.ones(count) for name in SCALES}
    solution = Solution(
        degree=2, times=loads.times, channels=loads.channels, values=loads.values,
        cycle=loads.cycle, coordinates=("press", "shear"), amplitudes=amplitudes,
        forces=forces * [-1.0, 1.0], drivers=("press", "shear"), driver_values=forces,
        contacts=contacts, iterations=np.r_[0, np.full(count - 1, 3)],
        parts=np.ones(count, dtype=int), fallbacks=np.zeros(count, dtype=int),
        certificates=certificates,
    )  # fmt: skip
    return Result(
        case=case, loads=loads, contacts=evaluate(solution), backend="fem",
        root_solution=solution, bodies=bodies(),
    )  # fmt: skip


@cache
def stationed_sphere() -> Result:
    """The contact on a flat surface with twelve stations, whose factors nobody has computed."""
    result = solid_result({"main": surface()})
    (contact,) = result.solution.contacts
    tracks = follow_fronts(result.solution, contact, 12)
    (area,) = result.contacts
    fronts = evaluate_fronts(result.solution, contact, tracks)
    return replace(result, contacts=(replace(area, fronts=fronts),))


def straight(*, mirrored: bool) -> Result:
    """A straight front of length 3 along x with 12 stations; the bodies go on at its end or not."""
    result = stationed_sphere()
    (contact,) = result.contacts
    (front,) = contact.fronts
    arcs = (np.arange(12) + 0.5) * LENGTH / 12
    stations = []
    for station, arc in zip(front.stations, arcs, strict=True):
        frame = replace(station.frame, along=np.array([1.0, 0.0, 0.0]))
        to_end = arc if mirrored else min(arc, LENGTH - arc)
        stations.append(
            replace(
                station,
                frame=frame,
                point=np.array([arc, 0.0, 0.0]),
                arc=arc,
                to_end=to_end,
                end=to_end < 0.5,
                k_range=10.0 - arc,
                k_range_spread=0.1,
            )
        )
    opened = replace(front, stations=tuple(stations), closed=False, length=LENGTH)
    return replace(result, contacts=(replace(contact, fronts=(opened,)),))


def with_stations(result: Result, change: Callable[[Station], Station]) -> Result:
    """Results of one contact with other stations."""
    (contact,) = result.contacts
    fronts = tuple(
        replace(front, stations=tuple(change(each) for each in front.stations))
        for front in contact.fronts
    )
    return replace(result, contacts=(replace(contact, fronts=fronts),))


def exact_station(station: Station, load: Array, angle: float) -> Station:
    """A station with K_N and K_I of the circle, and (K_T, K_S) of a bonded one.

    Args:
        station: one of a circle of radius 1.
        load: (T,) Q/(f P).
        angle: of the shear from inward towards along, degrees, between -90 and 90.
    """
    k = load * LIMIT
    pressed = np.minimum(np.arange(len(k)) / PRESSING, 1.0) ** (1 / 3)
    return replace(
        station, depth=1.0, length=1.0, curvature=1.0, k_angle=angle, turning=0.0, stiffening=2.0,
        k_n=np.full(len(k), K_N), k_n_spread=np.full(len(k), 0.03 * K_N),
        k_range=float(np.ptp(k)), k_range_spread=0.04 * float(np.ptp(k)), k_i_range=0.0,
        k_t=np.cos(np.radians(angle)) * k, k_s=np.sin(np.radians(angle)) * k,
        k_i=K_N / 3 * pressed**1.5, hold=K_N / 3 * pressed**1.5, shear=k, unit=np.ones(len(k)),
    )  # fmt: skip


def block(low: tuple[float, ...], high: tuple[float, ...], count: int = 8) -> BodyMesh:
    """count³ hexahedra."""
    lines = [np.linspace(a, b, count + 1) for a, b in zip(low, high, strict=True)]
    points = np.stack([each.ravel() for each in np.meshgrid(*lines, indexing="ij")], axis=1)
    i, j, k = (each.ravel() for each in np.meshgrid(*[np.arange(count)] * 3, indexing="ij"))
    steps = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0),
                      (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])  # fmt: skip
    size = np.array([(count + 1) ** 2, count + 1, 1])
    cells = (np.stack([i, j, k], axis=1)[:, None] + steps) @ size
    return BodyMesh("", points, cells, "hexahedron", 1, {})


def bodies() -> dict[str, BodyMesh]:
    """A pad on a larger block."""
    return {
        "upper": block((-2.0, 0.0, -2.0), (2.0, 2.0, 2.0)),
        "lower": block((-3.0, -2.0, -2.0), (3.0, 0.0, 2.0)),
    }


# Edges of a tetrahedron in VTK's order, and six tetrahedra of a hexahedron.
EDGES = np.array([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])
SIX = np.array([(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)])


def element_nodes(body: BodyMesh, *, tetrahedra: bool) -> Array:
    """(m, k, 3) nodes of hexahedra of order 1, or of tetrahedra of order 2."""
    nodes = body.points[body.cells]
    if not tetrahedra:
        return nodes
    corners = nodes[:, SIX].reshape(-1, 4, 3)
    return np.concatenate([corners, corners[:, EDGES].mean(axis=2)], axis=1)


def field_values(points: Array, time: float) -> tuple[Array, Array]:
    """Displacement (..., 3) and stress (..., 6) of a made-up state: a loaded spot at the origin."""
    distance = np.linalg.norm(points - [0.3 * np.sin(2 * np.pi * time), -0.5, 0.0], axis=-1)
    stress = np.zeros((*points.shape[:-1], 6))
    stress[..., 1] = -PEAK * np.exp(-(distance**2))
    moved = 1e-3 * np.stack([points[..., 1], -1 - 0 * distance, 0 * distance], axis=-1)
    return moved, stress


def write_solid(folder: Path, **settings: Any) -> Path:
    """The results of a run with fields at its load extremes and at its end."""
    result = solid_result(**settings)
    folder.mkdir(parents=True, exist_ok=True)
    write_results(folder, result)
    nodes = {
        name: element_nodes(body, tetrahedra=name == "lower") for name, body in bodies().items()
    }
    with closing(FieldWriter(folder / FIELDS, nodes)) as writer:
        for state in field_states(result):
            time = float(result.loads.times[state])
            pairs = [field_values(each, time) for each in nodes.values()]
            moved, stress = (list(each) for each in zip(*pairs, strict=True))
            writer.add(time, {"displacement": moved, "stress": stress})
    return folder


def field_states(result: Result) -> list[int]:
    """Load extremes and last state."""
    shears = result.contacts[0].shear_force[:, 0]
    assert result.loads.cycle is not None
    first, last = result.loads.cycle
    part = shears[first : last + 1]
    return sorted({first + int(part.argmax()), first + int(part.argmin()), last})
