# SPDX-License-Identifier: LGPL-3.0-or-later
"""K_I, K_T, K_S along curved fronts by interaction integrals, against closed forms."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from campaign.extent import every_so_many_weeks
from cases import blocks
from cases.contact_runs import ramp
from reference import bonded_circle
from reference.bonded import Fields, bonded

from fretfe._typing import Array, Bools
from fretfe.case import Solid, parse_case
from fretfe.evaluate.space.fronts import AREAS, OUTSIDE
from fretfe.fem._compat import MPI
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.interaction_integral import InteractionForm, Tip, Tube
from fretfe.fem.model import Model
from fretfe.fem.probes import Probe, probe_stations
from fretfe.materials.crystals import isotropic
from fretfe.materials.material import Material
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import BodyMesh, Mesh

SIZE, HALF, DEPTH = 0.1, 1.6, 0.6
POISSON = 0.3
ANGLES = np.linspace(0.0, 2 * np.pi, 7)[:-1] + 0.1
# (K_I, K_T, K_S) by P, Q, M are told relative to the largest of the load.
LARGEST = np.abs(bonded_circle.factors(np.array([0.0]))[0]).max(axis=0)
# About an axis that is none of the mesh's.
TURN = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]


@dataclass(frozen=True)
class Half:
    """A part of a half-space around the circle, and its displacements by P, Q and M."""

    form: InteractionForm
    displacements: Array


@cache
def half(upper: bool, cell: str, turned: bool = False, crystal: bool = False) -> Half:
    count = round(2 * HALF / SIZE)
    span = np.linspace(-HALF, HALF, count + 1)
    depth = np.linspace(0.0, DEPTH, round(DEPTH / SIZE) + 1)
    name, side = ("pad", "bottom") if upper else ("block", "top")
    plane = blocks.block(name, span, depth if upper else depth - DEPTH, cell=cell)
    whole = extrude(Mesh({name: plane}), Solid(length=2 * HALF, layers=count)).bodies[name]
    places = whole.points - [0.0, 0.0, HALF]
    turn = TURN if turned else np.eye(3)
    mesh = BodyMesh(name, places @ turn.T, whole.cells, whole.cell, whole.order, whole.boundaries)
    material = Material(100.0, POISSON, 0.0, "strain")
    if crystal:
        rows = tuple(map(tuple, isotropic(100.0, POISSON).tolist()))
        material = replace(material, crystal=rows)
    elastic = ElasticBody(MPI.COMM_WORLD, mesh if MPI.COMM_WORLD.rank == 0 else None, material, 2)
    points = elastic.space.tabulate_dof_coordinates() @ turn
    moved = bonded_circle.displacements(points, upper, material.shear_modulus, POISSON)
    form = InteractionForm(elastic, [f"{name}_{side}"], upper)
    return Half(form, np.einsum("ij,njk->nik", turn, moved))


def integrals(
    tube: Tube, cell: str, *, turned: bool = False, curvature: float = 1.0, crystal: bool = False
) -> Array:
    """(n, 3, 3) factors at ANGLES by P, Q and M."""
    points, frames = bonded_circle.frames(ANGLES)
    if turned:
        points, frames = points @ TURN.T, frames @ TURN.T
    tips = [Tip(*each, curvature) for each in zip(points, frames, strict=True)]
    bodies = [half(upper, cell, turned, crystal) for upper in (True, False)]
    sums = [
        sum(body.form.products(tip, [tube], body.displacements)[0] for body in bodies)
        for tip in tips
    ]
    whole = MPI.COMM_WORLD.allreduce(np.array(sums))
    modulus = 50 / (1 - POISSON**2)
    shear_modulus = 50 / (1 + POISSON)
    scales = np.array([-modulus, modulus, shear_modulus]) / np.sqrt(2 * np.pi)
    return np.asarray(whole * scales[:, None])


def errors(found: Array) -> Array:
    return np.asarray(np.abs(found - bonded_circle.factors(ANGLES)) / LARGEST)


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"], ids=["tetrahedra", "hexahedra"])
@pytest.mark.parametrize(
    ("reach", "half_length"), [pytest.param(0.3, 0.4, marks=pytest.mark.mpi), (0.4, 0.6)]
)
def test_exact_fields_of_a_circle(cell: str, reach: float, half_length: float) -> None:
    found = errors(integrals(Tube(reach, half_length), cell))
    # Interpolation of a singular field with ten elements along the radius.
    assert found.max() < 0.013
    assert found.mean(axis=0).max() < 0.008


def test_curvature_counts_where_the_front_leaves_the_tube() -> None:
    """A little of it makes no difference: the weight along the front has no second moment."""
    tube = Tube(0.2, 0.8)
    right, near, straight = (
        integrals(tube, "quadrilateral", curvature=k) / LARGEST for k in (1.0, 0.9, 0.0)
    )
    assert np.abs(near - right).max() < 4e-3  # .29 %
    assert np.abs(straight - right).max() > 0.02  # 3.3 %


@pytest.mark.mpi
def test_model_turned_as_a_whole() -> None:
    tube = Tube(0.3, 0.4)
    before, after = (integrals(tube, "quadrilateral", turned=turned) for turned in (False, True))
    np.testing.assert_allclose(after, before, atol=1e-9 * LARGEST.max())


@pytest.mark.mpi
def test_fields_of_crystals_bend_with_the_front() -> None:
    """With constants that are isotropic, of which fronts in any axes have the isotropic numbers."""
    tube = Tube(0.3, 0.4)
    before, after = (
        integrals(tube, "quadrilateral", turned=True, crystal=crystal) for crystal in (False, True)
    )
    np.testing.assert_allclose(after, before, atol=1e-6 * LARGEST.max())


LENGTH = 0.7


def pad_case(solid: bool, young: float) -> dict[str, Any]:
    platen = {"type": "platen", "boundary": "pad_top", "control": "force"}
    bodies = ("pad", "block")
    ends = {
        f"{body}_{end}": {"boundary": f"{body}_{end}", "fix": ["z"]}
        for body in bodies
        for end in ("front", "back")
    }
    base = {"boundary": "block_bottom", "fix": ["x", "y"]}
    return {
        "geometry": {"file": "none.msh"},
        "model": {} if solid else {"thickness": LENGTH},
        "bodies": {name: {"young": 1000.0, "poisson": 0.3} for name in bodies},
        "contacts": {"main": {"surface1": "pad_bottom", "surface2": "block_top", "friction": 1e4}},
        "loads": {
            "press": {**platen, "direction": "y", "history": ramp(-6.0)},
            "shear": {**platen, "direction": "x", "history": [{"hold": True, "until": 1}]},
        },
        "supports": {"base": base, **(ends if solid else {})},
    }


def pad_mesh() -> Mesh:
    """A pad whose lower side has a radius of 2, on a block."""

    def rounded(points: Array) -> Array:
        x, y = points.T
        return np.column_stack([x, y + (1 - y) * x**2 / 4])

    fine = np.linspace(-0.42, 0.42, 25)
    pad = blocks.block("pad", [-0.6, *fine, 0.6], [0.0, 0.04, 0.1, 0.2, 0.5, 1.0], mapping=rounded)
    base = blocks.block(
        "block", [-1.0, -0.6, *(0.95 * fine), 0.6, 1.0], [-1.0, -0.5, -0.2, -0.1, -0.04, 0.0]
    )
    return Mesh({"pad": pad, "block": base})


@dataclass(frozen=True)
class Stations:
    """Stations of a front; see `probe_stations`."""

    points: Array
    inward: Array
    along: Array
    across: Array
    curvature: Array


EDGE = 0.2  # about where the contact ends


def straight_probes(model: Model, root: Fields) -> list[Probe]:
    """Both fronts of the solid at mid-length."""
    probes = []
    for inward in (1.0, -1.0):
        station = Stations(
            points=np.array([[-inward * EDGE, 0.0, LENGTH / 2]]),
            inward=np.array([[inward, 0.0, 0.0]]),
            across=np.array([[0.0, 1.0, 0.0]]),
            along=np.array([[0.0, 0.0, -inward]]),
            curvature=np.zeros(1),
        )
        tubes = [Tube(reach, LENGTH / 2) for reach in (0.15, 0.18)]
        probes.append(probe_stations(model, root.pair, station, [tubes], range(2)))
    return probes


def flat(probe: Probe) -> Probe:
    """The same in the plane."""
    return replace(
        probe,
        tips=tuple(
            (Tip(one.point[:2], one.frame[:2, :2]), Tip(two.point[:2], two.frame[:2, :2]))
            for one, two in probe.tips
        ),
        frames=tuple(frame[:2, :2] for frame in probe.frames),
    )


@pytest.mark.parametrize(
    "young",
    [pytest.param(1000.0, id="equal"), pytest.param(200.0, id="unlike", marks=pytest.mark.mpi)],
)
def test_extruded_contact_has_the_factors_of_the_plane(young: float) -> None:
    """A tensor product has the plane's solution, and a weight of whole layers its integrals."""
    mesh, extrusion = pad_mesh(), Solid(length=LENGTH, layers=4)
    solid = bonded(parse_case(pad_case(True, young)), lambda: extrude(mesh, extrusion))
    plane = bonded(parse_case(pad_case(False, young)), lambda: mesh)
    probes = straight_probes(solid.model, solid.root) if solid.root else []
    found = solid.factors(lambda *_: probes)
    expected = plane.factors(lambda *_: [flat(probe) for probe in probes])
    assert (found is None) == (expected is None)
    for front, flat_front in zip(found or [], expected or [], strict=True):
        # Forces of the plane are per unit thickness.
        largest = np.abs(flat_front).max()
        np.testing.assert_allclose(front[:, :, :2] * LENGTH, flat_front, atol=1e-8 * largest)
        assert np.abs(front[:, :, 2]).max() * LENGTH < 1e-8 * largest


YOUNG = 2e5


@dataclass(frozen=True)
class Ellipse:
    """A contact with half axes along x and z."""

    a: float
    b: float

    def angles(self, count: int) -> Array:
        return np.asarray(2 * np.pi * (np.arange(count) + 0.3) / count)

    def stations(self, count: int) -> Stations:
        """Right-handed about y: z runs against the angle."""
        cosine, sine = np.cos(self.angles(count)), np.sin(self.angles(count))
        none, across = 0 * cosine, np.tile([0.0, 1.0, 0.0], (count, 1))
        tangent = np.column_stack([-self.a * sine, none, -self.b * cosine])
        length = np.linalg.norm(tangent, axis=1)
        along = -tangent / length[:, None]
        return Stations(
            points=np.column_stack([self.a * cosine, none, -self.b * sine]),
            inward=np.cross(along, across),
            along=along,
            across=across,
            curvature=self.a * self.b / length**3,
        )

    def factors(self, count: int) -> Array:
        """(n, 3, 3) K_I, K_T, K_S by P, Q along x and M about y; that by M of a circle."""
        angles, stations = self.angles(count), self.stations(count)
        root = np.sqrt(2 * np.hypot(np.cos(angles) / self.a, np.sin(angles) / self.b))
        size = 1 / (2 * np.pi * self.a * self.b * root)
        found = np.zeros((count, 3, 3))
        found[:, 0, 0] = size
        found[:, 1, 1], found[:, 2, 1] = size * stations.inward[:, 0], size * stations.along[:, 0]
        found[:, 2, 2] = -1.5 * size / self.a
        return found

    def areas(self, points: Array, step: float) -> list[Bools]:
        """Areas whose borders pass the nodes next to the ellipse one after the other."""
        level = np.hypot(points[:, 0] / self.a, points[:, 2] / self.b)
        slope = np.hypot(points[:, 0] / self.a**2, points[:, 2] / self.b**2)
        outside = (level - 1) * level / np.maximum(slope, 1e-9)
        shifts = step * ((np.arange(AREAS) + 0.5) / AREAS - 0.5 - OUTSIDE)
        return [outside < shift for shift in shifts]


def ball_case(ellipse: Ellipse, size: float, poisson: float) -> dict[str, Any]:
    def platen(direction: str) -> dict[str, Any]:
        kind = {"type": "platen", "boundary": "upper_top", "control": "force"}
        return {**kind, "direction": direction, "history": ramp(-1.0)}

    twist = {"type": "tilt", "boundary": "upper_top", "axis": "y", "centre": [0, 0, 0]}
    parameters = {"size": size, "contact_x": ellipse.a, "contact_z": ellipse.b}
    return {
        "geometry": {"template": "sphere", "parameters": parameters},
        "bodies": {name: {"young": YOUNG, "poisson": poisson} for name in ("upper", "lower")},
        "contacts": {
            "main": {"surface1": "upper_contact", "surface2": "lower_contact", "friction": 1e4}
        },
        "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}},
        "loads": {
            "press": platen("y"),
            "shear": platen("x"),
            "twist": {**twist, "control": "moment", "history": ramp(1.0)},
        },
    }


def ball_errors(
    ellipse: Ellipse, size: float, poisson: float, tubes: list[Tube], count: int = 24
) -> Array:
    """(R, n, 3, 3) errors by P, Q and M relative to the largest factor of the load, signed."""
    found = bonded(
        parse_case(ball_case(ellipse, size, poisson)),
        areas=lambda points: ellipse.areas(points, size),
    ).factors(
        lambda model, root: [
            probe_stations(model, root.pair, ellipse.stations(count), [tubes] * count, range(3))
        ]
    )
    (values,) = MPI.COMM_WORLD.bcast(found)
    values = values * [-1.0, 1.0, 1.0]  # a unit along y pulls
    expected = ellipse.factors(count)
    return np.asarray((values - expected) / np.abs(expected).max(axis=(0, 1)))


# Errors are those of the mesh: the bonded front is as ragged as the nodes at it.
@pytest.mark.slow
@every_so_many_weeks(2, 0)
def test_bonded_sphere() -> None:
    """Twelve elements over the radius: one per cent low on the average, the least for P."""
    errors = ball_errors(Ellipse(1.0, 1.0), 1 / 12, 0.3, [Tube(0.3, 0.6), Tube(0.4, 0.8)])
    means = np.abs(errors.mean(axis=1))
    assert means.max() < 0.02  # 1.1, 1.0 and 1.6 % by P, Q and M
    assert np.abs(errors).max() < 0.05  # 2.8, 2.9 and 3.9 %
    # What a load does not cause.
    assert np.abs(errors[..., [1, 2], 0]).max() < 5e-3
    assert np.abs(errors[..., [0, 1], 2]).max() < 1e-2
    # Independent of the reach.
    assert np.abs(errors[1] - errors[0]).mean() < 5e-3


@pytest.mark.slow
@every_so_many_weeks(2, 1)
def test_bonded_ellipse() -> None:
    """Eight elements over the smaller half axis, four over the radius of the front at its ends."""
    ellipse = Ellipse(1.0, 0.5)
    errors = ball_errors(ellipse, 1 / 16, 0.3, [Tube(0.12, 0.3)])[..., :2]
    assert np.abs(errors.mean(axis=1)).max() < 0.01  # .3 and .1 %
    assert np.abs(errors).max() < 0.065  # 5.7 and 3.5 %
    sharp = ellipse.stations(24).curvature > 2.0
    assert np.abs(errors[:, ~sharp]).max() < 0.035  # 2.7 %
