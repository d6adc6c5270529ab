# SPDX-License-Identifier: LGPL-3.0-or-later
"""Interface problems between half-planes: compliance in closed form, no finite elements.

Tractions are hat functions on given nodes as in `halfplane_galerkin`. The logarithm is taken of
|x - y| / `far`, which adds a constant compliance and makes the matrix positive definite as long as
`far` is large compared with the contact. Contacts do not feel each other elastically, only through
the rigid motion of body 1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from reference import halfplane_galerkin as galerkin

from fretfe._typing import Array
from fretfe.contact.interface import Coordinate, DenseCompliance, Interface
from fretfe.contact.state import StepLoads


@dataclass(frozen=True)
class Flank:
    """One contact: nodes along t, the two outermost without traction; gap as its second integral.

    n makes `angle` degrees with y, at `centre` of the plane in which body 1 moves.
    """

    nodes: Array
    gap_second_integral: Callable[[Array], Array]
    angle: float = 0.0
    centre: tuple[float, float] = (0.0, 0.0)

    @property
    def weights(self) -> Array:
        return galerkin.hat_integrals(self.nodes, lambda x: x**2 / 2)

    @property
    def frame(self) -> Array:
        """(2, 2) rows n, t."""
        c, s = np.cos(np.radians(self.angle)), np.sin(np.radians(self.angle))
        return np.array([[-s, c], [c, s]])


def flank_compliance(flank: Flank, modulus: float, far: float, beta: float) -> Array:
    """(n*2, n*2) A; `beta` is Dundurs' second constant, which couples pressure and shear."""
    weights = flank.weights
    matrix = galerkin.compliance(flank.nodes) + 2 / np.pi * np.log(far) * np.outer(weights, weights)
    x = flank.nodes.astype(np.longdouble)
    fourth = np.sign(x[:, None] - x) * np.abs(x[:, None] - x) ** 4 / 24
    second = galerkin.second_differences(flank.nodes)
    coupling = np.asarray(beta * (second @ fourth @ second.T), dtype=float)
    roots = np.sqrt(weights)
    full = np.zeros((len(weights), 2, len(weights), 2))
    full[:, 0, :, 0] = full[:, 1, :, 1] = matrix
    full[:, 0, :, 1] = coupling
    full[:, 1, :, 0] = coupling.T
    full /= (roots[:, None] * roots)[:, None, :, None] * modulus
    return full.reshape(2 * len(weights), -1)


def rigid_motion(flank: Flank) -> Array:
    """(n*2, 3) w by unit translations x, y and a unit rotation of body 1."""
    roots, x = np.sqrt(flank.weights), flank.nodes[1:-1]
    points = np.array(flank.centre) + x[:, None] * flank.frame[1]
    moves = np.zeros((len(x), 2, 3))
    moves[:, 0, 0] = moves[:, 1, 1] = 1.0
    moves[:, 0, 2], moves[:, 1, 2] = -points[:, 1], points[:, 0]
    relative = np.einsum("cd,ndm->ncm", flank.frame * np.array([[1.0], [-1.0]]), moves)
    return (roots[:, None, None] * relative).reshape(-1, 3)


def build(
    flanks: Sequence[Flank],
    controls: Sequence[str],
    *,
    modulus: float = 1.0,
    far: float = 100.0,
    beta: float = 0.0,
) -> Interface:
    """Body 1 with coordinates x, y and rotation, each "force", "displacement", "fixed" or "free".

    `modulus` is E*. Lengths are those of the nodes.
    """
    blocks = [flank_compliance(flank, modulus, far, beta) for flank in flanks]
    sizes = [len(block) for block in blocks]
    ends = np.cumsum([0, *sizes])
    compliance = np.zeros((ends[-1], ends[-1]))
    for block, start, end in zip(blocks, ends[:-1], ends[1:], strict=True):
        compliance[start:end, start:end] = block
    gap = np.zeros((ends[-1] // 2, 2))
    roots = np.concatenate([np.sqrt(flank.weights) for flank in flanks])
    weighted = [galerkin.hat_integrals(f.nodes, f.gap_second_integral) for f in flanks]
    gap[:, 0] = np.concatenate(weighted) / roots
    labels = ("x", "y", "rotation")
    return Interface(
        components=2,
        compliance=DenseCompliance(compliance),
        gap=gap.ravel(),
        motion=np.vstack([rigid_motion(flank) for flank in flanks]),
        stiffness=np.zeros((3, 3)),
        loads=np.zeros((ends[-1], 0)),
        coordinate_loads=np.zeros((3, 0)),
        roots=roots,
        coordinates=tuple(
            Coordinate(label, "one", control)
            for label, control in zip(labels, controls, strict=True)
        ),
        contacts={
            f"contact{number}": slice(int(start) // 2, int(end) // 2)
            for number, (start, end) in enumerate(pairwise(ends))
        },
    )


def converted(interface: Interface, length: float, stress: float) -> Interface:
    """The same problem in other units: so many new ones in an old one. Rotation stays an angle."""
    root = np.sqrt(length)
    components = np.arange(len(interface.gap))
    matrix = interface.compliance.block(components, components)
    units = np.array([length, length, 1.0])
    return replace(
        interface,
        compliance=DenseCompliance(matrix * length / stress),
        gap=interface.gap * length * root,
        motion=interface.motion * (length * root / units),
        roots=interface.roots * root,
    )


def parabola(radius: float) -> Callable[[Array], Array]:
    """Second integral of the gap x^2 / (2 R)."""
    return lambda x: x**4 / (24 * radius)


def loads(interface: Interface, values: Sequence[float] | Array, friction: float) -> StepLoads:
    """Amplitudes or forces of x, y and rotation of body 1."""
    return StepLoads(np.empty(0), np.asarray(values, float), np.full(interface.size, friction))
