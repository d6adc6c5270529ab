# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plane cases as solids: straight extrusions, their ends held along z.

With hexahedra that are a tensor product of a plane mesh and layers along z, the solution of the
plane problem is that of the solid, to round-off: the residual of a solution that does not depend on
z, against φ(x, y) ψ(z) e_z, is σ_zz φ ∫ψ' = 0. With tetrahedra it is so to the error of the mesh.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from campaign.extent import every_so_many_weeks
from cases import blocks
from cases.contact_runs import ramp
from scipy.spatial import cKDTree

from fretfe._typing import Array
from fretfe.case import Case, Solid, parse_case
from fretfe.evaluate.verdicts import longest_verdict
from fretfe.fem._compat import MPI
from fretfe.fem.run import solve
from fretfe.history.solution import OPEN, ContactHistory
from fretfe.mesh.elements import reference_nodes, shape_values
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.make import mesh_template
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.mesh.templates import find_template
from fretfe.results.model import Result
from fretfe.verdict import Verdict

LENGTH = 0.7
# Where nothing is asked about fronts, which take most of the time.
NO_FRONTS = {"edges": {"stations": 8, "local": False}}


def solve_on(case: Case, mesh: Mesh) -> Result:
    return solve(MPI.COMM_WORLD, case, load=lambda: mesh)


def as_solid(data: dict[str, Any]) -> dict[str, Any]:
    """The case of a solid whose ends do not move along z."""
    ends = {
        f"{body}_{end}": {"boundary": f"{body}_{end}", "fix": ["z"]}
        for body in data["bodies"]
        for end in ("front", "back")
    }
    data = {**data, "supports": {**data.get("supports", {}), **ends}}
    del data["model"]["thickness"]
    return data


def compare(plane: Result, solid: Result, tolerance: float) -> None:
    """Tractions, slip and forces of a solid are those of the plane, in every state."""
    flat, space = plane.solution, solid.solution
    assert flat is not None and plane.failure is None
    assert space is not None and solid.failure is None
    for contact in space.contacts:
        patches = [each for each in flat.contacts if each.pair == contact.pair]
        compare_contacts(whole(patches), contact, tolerance)
    expected = flat.forces * LENGTH
    found = space.forces[:, [space.coordinates.index(name) for name in flat.coordinates]]
    np.testing.assert_allclose(found, expected, atol=tolerance * np.abs(expected).max())


def whole(patches: list[ContactHistory]) -> ContactHistory:
    """A pair of surfaces from its patches, each of which carries nothing outside its own part."""
    return replace(
        patches[0],
        traction=np.sum([np.asarray(each.traction) for each in patches], axis=0),
        status=np.max([np.asarray(each.status) for each in patches], axis=0),
    )


def compare_contacts(flat: ContactHistory, space: ContactHistory, tolerance: float) -> None:
    """The nodes of the solid are those of the plane, layer by layer."""
    places = cKDTree(flat.surface.points)
    distance, rows = places.query(space.surface.points[:, :2])
    assert distance.max() < 1e-9
    # The first tangent is that of the plane.
    np.testing.assert_allclose(
        space.surface.frames[:, 1, :2], flat.surface.frames[rows, 1], atol=1e-7
    )
    expected, found = np.asarray(flat.traction)[:, rows], np.asarray(space.traction)
    scale = tolerance * np.abs(expected).max()
    assert scale > 0
    np.testing.assert_allclose(found[..., :2], expected, atol=scale)
    np.testing.assert_allclose(found[..., 2], 0.0, atol=scale)
    slip = np.asarray(flat.slip)[:, rows]
    closed = np.asarray(flat.status)[:, rows] != OPEN
    difference = np.where(closed, np.asarray(space.slip)[..., 0] - slip[..., 0], 0.0)
    np.testing.assert_allclose(difference, 0.0, atol=tolerance * np.abs(slip).max())


def compare_limits(plane: Result, solid: Result) -> None:
    """The motion of the surfaces is the same; strains are compared next to slip borders, too."""
    of_plane, of_solid = (
        {limit.quantity: limit.found for limit in each.limits} for each in (plane, solid)
    )
    of_a_flat = "sliding over the sum of the radii of both surfaces"
    assert of_plane[of_a_flat] == of_solid[of_a_flat] == 0.0
    for name in (
        "rotation of a body at the contact",
        "largest slope that a surface takes in the contact",
        "stretch of a surface, root mean square over the contact",
    ):
        assert of_plane[name] > 0
        assert of_solid[name] == pytest.approx(of_plane[name], rel=0.03), name
    assert of_solid.keys() == of_plane.keys()


def pad_case() -> dict[str, Any]:
    platen = {"type": "platen", "boundary": "pad_top", "control": "force"}
    shear = [
        {"hold": True, "until": 1},
        {"ramp": 1.5, "until": 2, "steps": 2},
        {"ramp": -1.5, "until": 3, "steps": 3},
    ]
    return {
        "geometry": {"file": "none.msh"},
        "model": {"thickness": LENGTH},
        "bodies": {name: {"young": 1000.0, "poisson": 0.3} for name in ("pad", "block")},
        "contacts": {"main": {"surface1": "pad_bottom", "surface2": "block_top", "friction": 0.4}},
        "loads": {
            "press": {**platen, "direction": "y", "history": ramp(-6.0)},
            "shear": {**platen, "direction": "x", "history": shear},
        },
        "supports": {"base": {"boundary": "block_bottom", "fix": ["x", "y"]}},
    }


def rounded(points: Array) -> Array:
    """A pad whose lower side has a radius of 2."""
    x, y = points.T
    return np.column_stack([x, y + (1 - y) * x**2 / 4])


def pad_meshes(order: int, cell: str = "quadrilateral") -> Mesh:
    x = np.linspace(-0.6, 0.6, 17)
    pad = blocks.block("pad", x, [0.0, 0.15, 0.5, 1.0], order=order, mapping=rounded, cell=cell)
    wide = np.linspace(-1.0, 1.0, 21)
    base = blocks.block("block", wide, [-1.0, -0.5, -0.15, 0.0], order=order, cell=cell)
    return Mesh({"pad": pad, "block": base})


@pytest.mark.parametrize("order", [1, 2])
def test_extruded_pad_is_the_plane_pad(order: int) -> None:
    data, mesh = {**pad_case()}, pad_meshes(order)
    data["model"]["degree"] = order
    plane = solve_on(parse_case(data), mesh)
    extruded = extrude(mesh, Solid(length=LENGTH, layers=2))
    solid = solve_on(parse_case(as_solid(data) | NO_FRONTS), extruded)
    compare(plane, solid, 1e-9)
    compare_limits(plane, solid)


def test_gaps_follow_sliding_in_an_extruded_pad_as_in_the_plane() -> None:
    """With a rounding on the pad at one end, and on the block at the other one."""

    def left(points: Array) -> Array:
        x, y = points.T
        return np.column_stack([x, y + (1 - y) * np.minimum(x + 0.2, 0.0) ** 2 / 4])

    def right(points: Array) -> Array:
        x, y = points.T
        return np.column_stack([x, y - (1 + y) * np.maximum(x - 0.2, 0.0) ** 2 / 4])

    x, y = np.linspace(-0.6, 0.6, 17), np.array([0.0, 0.15, 0.5, 1.0])
    wide = np.linspace(-1.0, 1.0, 21)
    parts = {
        "pad": blocks.block("pad", x, y, order=1, mapping=left, cell="quadrilateral"),
        "block": blocks.block(
            "block", wide, -y[::-1], order=1, mapping=right, cell="quadrilateral"
        ),
    }
    data, mesh = pad_case(), Mesh(parts)
    data["model"]["degree"] = 1
    data["contacts"]["main"]["friction"] = 0.0
    slide = [{"hold": True, "until": 1}, {"ramp": 0.1, "until": 2, "steps": 2}]
    data["loads"]["shear"] |= {"control": "displacement", "history": slide}
    plane = solve_on(parse_case(data), mesh)
    extruded = extrude(mesh, Solid(length=LENGTH, layers=2))
    solid = solve_on(parse_case(as_solid(data) | NO_FRONTS), extruded)
    (contact,), (flat,) = solid.solution.contacts, plane.solution.contacts
    before, after = (np.asarray(flat.traction)[state, :, 0] for state in (-3, -1))
    assert np.abs(after - before).max() > 0.05 * before.max()
    compare_contacts(flat, contact, 1e-9)


def pairing_error(result: Result) -> float:
    (found,) = (each.found for each in result.limits if "gap times rotation" in each.quantity)
    return found


def test_the_pairing_error_of_an_extruded_pad() -> None:
    """That of the plane pad, up to what bodies of this height do to K_T."""
    x = np.linspace(-0.25, 0.25, 41)
    ends = np.array([0.32, 0.42, 0.6])
    pad_x = np.r_[-ends[::-1], x, ends]
    block_x = np.r_[-1.0, -0.7, pad_x[1:-1], 0.7, 1.0]
    pad_y = [0.0, 0.02, 0.06, 0.15, 0.5, 1.0]
    upper = blocks.block("pad", pad_x, pad_y, order=1, mapping=rounded, cell="quadrilateral")
    lower = blocks.block("block", block_x, [-y for y in pad_y[::-1]], order=1, cell="quadrilateral")
    wave_ = {"wave": "sine", "amplitude": 1.0, "period": 1.0, "cycles": 1, "steps_per_cycle": 4}
    data = pad_case()
    data["model"]["degree"] = 1
    data["loads"]["shear"]["history"] = [{"hold": True, "until": 1}, wave_]
    mesh = Mesh({"pad": upper, "block": lower})
    plane = solve_on(parse_case({**data, "model": {**data["model"]}}), mesh)
    extruded = extrude(mesh, Solid(length=LENGTH, layers=1))
    solid = solve_on(parse_case(as_solid(data) | NO_FRONTS), extruded)
    expected, found = (pairing_error(each) for each in (plane, solid))
    assert 0.002 < found == pytest.approx(expected, rel=0.15)


@pytest.mark.parametrize("layers", [2, 3])
def test_stations_next_to_the_ends_have_the_factors_of_the_plane(layers: int) -> None:
    """Half-way between an end and a twelfth of the length: a tenth of a layer, or less.

    The ends are planes of symmetry: no station is near a free one.
    """
    ends, y = np.array([0.32, 0.42, 0.65]), [0.0, 0.02, 0.06, 0.15, 0.5, 1.0]
    pad_x = np.r_[-ends[::-1], np.linspace(-0.3, 0.3, 31), ends]
    block_x = np.r_[-1.0, -0.7, pad_x[1:-1], 0.7, 1.0]
    upper = blocks.block("pad", pad_x, y, mapping=rounded, cell="quadrilateral")
    lower = blocks.block("block", block_x, [-each for each in y[::-1]], cell="quadrilateral")
    data = {**pad_case(), "edges": {"stations": 12}}
    wave_ = {"wave": "sine", "amplitude": 1.0, "period": 1.0, "cycles": 1, "steps_per_cycle": 4}
    data["loads"]["shear"]["history"] = [{"hold": True, "until": 1}, wave_]
    mesh = Mesh({"pad": upper, "block": lower})
    plane = solve_on(parse_case({**data, "model": {**data["model"]}}), mesh)
    whole = extrude(mesh, Solid(length=LENGTH, layers=layers))
    solid = solve_on(parse_case(as_solid(data)), whole)
    truth, fronts = plane.contacts[0].stations[0], solid.contacts[0].fronts
    assert len(fronts) == 2
    for front in fronts:
        found, bar, normal = map(front.along, ("k_range", "k_range_spread", "k_i_range"))
        # Circles and tubes of other radii on one mesh.
        np.testing.assert_allclose(found, truth.k_range, rtol=0.01)
        # What quadrature makes of the weight.
        np.testing.assert_allclose(found, found[6], rtol=0.002)
        np.testing.assert_allclose(normal, normal[6], rtol=0.002)
        assert bar == pytest.approx(bar[6], rel=0.1)
        verdicts = [longest_verdict(each) for each in front.stations]
        assert {each.verdict for each in verdicts} == {verdicts[6].verdict} != {Verdict.END}
        lengths = [each.slip_zones[-1].local for each in front.stations]
        np.testing.assert_allclose(lengths, lengths[6], rtol=0.01)


# Corners of the three quadrilaterals in a triangle: a vertex, the middle of an edge, the middle of
# the triangle, the middle of the other edge.
MIDDLE = [1 / 3, 1 / 3]
PARTS = [
    [[0, 0], [0.5, 0], MIDDLE, [0, 0.5]],
    [[1, 0], [0.5, 0.5], MIDDLE, [0.5, 0]],
    [[0, 1], [0, 0.5], MIDDLE, [0.5, 0.5]],
]


def in_quadrilaterals(mesh: Mesh) -> Mesh:
    """A mesh of curved triangles with each of them parted into three quadrilaterals."""
    return Mesh({name: _parted(body) for name, body in mesh.bodies.items()})


def _parted(body: BodyMesh) -> BodyMesh:
    square = shape_values("quadrilateral", 1, reference_nodes("quadrilateral", 2))
    at = np.concatenate([square @ np.array(part) for part in PARTS])
    corners = np.einsum("qk,mkd->mqd", shape_values("triangle", 2, at), body.points[body.cells])
    halves = shape_values("line", 2, np.array([[0.0], [0.5], [0.25], [0.5], [1.0], [0.75]]))
    lines = {
        group: np.einsum("qk,fkd->fqd", halves, body.points[facets])
        for group, facets in body.boundaries.items()
    }
    everything = np.concatenate([each.reshape(-1, 2) for each in (corners, *lines.values())])
    _, first, numbers = np.unique(
        everything.round(9), axis=0, return_index=True, return_inverse=True
    )
    ends = np.cumsum([corners[..., 0].size, *(each[..., 0].size for each in lines.values())])
    cells, *facets = np.split(numbers.ravel(), ends[:-1])
    return BodyMesh(
        body.name,
        everything[first],
        cells.reshape(-1, 9),
        "quadrilateral",
        2,
        {group: each.reshape(-1, 3) for group, each in zip(lines, facets, strict=True)},
    )


PULLED = {
    "firtree": {"lobes": 2, "edge_size": 0.06, "flank_size": 0.2, "growth": 0.5},
    "dovetail": {
        "edge_size": 0.15,
        "edge_zone": 0.3,
        "flank_size": 0.6,
        "growth": 0.5,
        "disc_width": 40.0,
        "disc_depth": 30.0,
    },
}


@pytest.mark.parametrize(
    ("name", "degree"),
    [
        ("dovetail", 1),
        pytest.param("dovetail", 2, marks=(pytest.mark.slow, every_so_many_weeks(2, 0))),
        pytest.param("firtree", 1, marks=(pytest.mark.slow, every_so_many_weeks(2, 1))),
    ],
)
def test_extruded_roots_are_the_plane_roots(name: str, degree: int) -> None:
    mesh = in_quadrilaterals(mesh_template(find_template(name), PULLED[name], 2))
    data = root_case(mesh)
    data["model"]["degree"] = degree
    plane = solve_on(parse_case(data), mesh)
    solid = extrude(mesh, Solid(length=LENGTH, layers=1))
    compare(plane, solve_on(parse_case(as_solid(data) | NO_FRONTS), solid), 1e-9)


def root_case(mesh: Mesh) -> dict[str, Any]:
    """A root that is pulled, let go of in part, and pulled again; all flanks in contact."""
    blade, disc = mesh.bodies
    flanks = sorted(group for group in mesh.bodies[blade].boundaries if "flank" in group)
    history = [
        {"ramp": 300.0, "until": 1, "steps": 3},
        {"ramp": 200.0, "until": 2, "steps": 2},
        {"ramp": 250.0, "until": 3, "steps": 1},
    ]
    held = [name for name in mesh.bodies[disc].boundaries if name.startswith(f"{disc}_side")]
    return {
        "geometry": {"file": "none.msh"},
        "model": {"thickness": LENGTH},
        "bodies": {each: {"young": 115e3, "poisson": 0.32} for each in (blade, disc)},
        "contacts": {
            each.removeprefix(f"{blade}_"): {
                "surface1": each,
                "surface2": each.replace(blade, disc),
                "friction": 0.6,
            }
            for each in flanks
        },
        "loads": {
            "pull": {
                "type": "platen",
                "boundary": f"{blade}_top",
                "direction": "y",
                "control": "force",
                "history": history,
            }
        },
        "supports": {
            "rim": {"boundary": f"{disc}_bottom", "fix": ["x", "y"]},
            **{each: {"boundary": each, "fix": ["x"]} for each in held},
        },
    }
