# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which templates are a profile on a large block, and which materials are similar enough."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.analytic.profiles import FlatRounded, Hertz, Profile, Wedge
from fretfe.case import AnyBody, Case, Plane, isotropic
from fretfe.materials.crystals import coupling
from fretfe.materials.material import Material
from fretfe.materials.moduli import contact_modulus, half_plane, half_planes

UPPER = "upper"
LOWER = "lower"
# Of the contact surface of the lower body, and with it a tangent.
NORMAL = np.array([0.0, 1.0])
FRAME = np.array([[0.0, 1.0], [1.0, 0.0]])
# Dundurs' second constant up to which bodies count as elastically similar. It couples pressure and
# shear: tractions change by about this fraction.
SIMILAR = 0.01
# Less than this is round-off of the constants of equal materials.
ROUND_OFF = 1e-12
# Compliances of crystals that differ by less than this part of them count as equal.
ALIKE = 1e-4

# Relative error of a half-plane in place of a body, times the square of the half-width of the
# contact over the height or half-width of the body. Measured by finite elements on cylinders, 3 to
# 10 half-widths high or wide: K_N 0.23 to 0.25 and 0.10 to 0.14, K_T up to 0.1 and 0.3 to 0.7.
K_N_BY_HEIGHT = 0.25
K_N_BY_WIDTH = 0.14
K_T_BY_HEIGHT = 0.1
K_T_BY_WIDTH = 0.7
# The same of flats with rounded edges, under which pressure and shear lie nearer to the edges: ΔK_T
# is .69 % high where .41 % are those of a cylinder (half-width 1.01 of 20, three amplitudes).
K_T_BY_WIDTH_OF_FLATS = 1.3
# Relative errors of K_T and, by the direction of slip, of slip zones over the slope with which the
# surfaces meet. Finite elements of wedges, 60 to 150 half-widths large: ΔK_T .6 % at 1 degree,
# 1.8 % at 3, 3.7 % at 6; slip zones up to 4.0 % at 3 and 6.8 % at 6.
K_T_BY_SLOPE = 0.4
SLIP_BY_SLOPE = 0.8


# Tension along the surface of a body under the contact that a half-plane does not have, over P by
# its height or half-width, the larger one. Finite elements of blocks on a smooth or rough base: .48
# and .40 of the former where they are half and as high as half of their width, .29 to .33 of the
# latter where they are higher; a disc 1/pi.
STRETCH_BY_HEIGHT = 0.5
STRETCH_BY_WIDTH = 0.3

# Half-planes carry Q away half to either side, a block with one side held along x carries all of it
# there: a tension of Q/(2 height) times a share, by the half-width over the height. By finite
# elements (nu = .3) of a block that slides on its base, whose share goes to 1, and of one that is
# held there too, whose share goes to 0. Of narrower blocks it is as the height over the half-width.
SHAPES = (0.3, 0.4, 0.5, 0.6, 0.75, 0.875, 1.0, 1.25, 1.5, 2.0, 3.0)
SLIDING_SHARES = (5.41, 3.97, 2.98, 2.28, 1.63, 1.33, 1.16, 1.03, 1.0, 1.0, 1.0)
HELD_SHARES = (5.35, 3.88, 2.93, 2.29, 1.63, 1.25, 0.96, 0.58, 0.35, 0.13, 0.02)
# Parts of them by which nu = .2 and .4 differ; of a sliding block it falls as the share does.
SLIDING_DOUBT = 0.12
HELD_DOUBT = 0.25


@dataclass(frozen=True)
class Block:
    """A template as far as half-planes know it: its profile and the size of its bodies.

    Attributes:
        profile: initial gap between the bodies.
        top_width: full width of the upper body's top.
        heights: of the upper and the lower body.
        half_widths: of the upper and the lower body.
        zone: half-width of the candidate contact zone.
    """

    profile: Profile
    top_width: float
    heights: tuple[float, float]
    half_widths: tuple[float, float]
    zone: float

    @property
    def smallest(self) -> float:
        """Smallest of the half-widths and heights of both bodies."""
        return min(*self.heights, *self.half_widths)

    def size_errors(self, reach: float) -> tuple[float, float]:
        """Relative errors of K_N and K_T to expect of half-planes in place of these bodies.

        By their size, and of K_T by the slope with which they meet.

        Args:
            reach: largest half-width of the contact.
        """
        low = sum((reach / height) ** 2 for height in self.heights)
        narrow = sum((reach / half_width) ** 2 for half_width in self.half_widths)
        flat = isinstance(self.profile, FlatRounded)
        by_width = K_T_BY_WIDTH_OF_FLATS if flat else K_T_BY_WIDTH
        return (
            K_N_BY_HEIGHT * low + K_N_BY_WIDTH * narrow,
            K_T_BY_HEIGHT * low + by_width * narrow + K_T_BY_SLOPE * self._slope,
        )

    @property
    def slip_error(self) -> float:
        """Relative error of slip zones to expect as surfaces that meet at a slope are no planes."""
        return SLIP_BY_SLOPE * self._slope

    @property
    def _slope(self) -> float:
        """With which the surfaces meet: that of a wedge, zero of those that are smooth."""
        return self.profile.slope if isinstance(self.profile, Wedge) else 0.0

    def stretch(self, *moduli: float, kept: float = 0.0) -> float:
        """Bulk tension by a unit of P, as P stretches the lower body by more than the upper one.

        Args:
            moduli: plane moduli of the upper and the lower body.
            kept: compression along the held sides of the lower body over that by P; 0 if it can
                spread.
        """
        sizes = zip(self.heights, self.half_widths, moduli, strict=True)
        upper, lower = (
            max(STRETCH_BY_HEIGHT / height, STRETCH_BY_WIDTH / half_width) / modulus
            for height, half_width, modulus in sizes
        )
        lower -= kept / (2 * self.half_widths[1] * moduli[1])
        return 2 * self.profile.e_star * (lower - upper)


def side_tension(half_width: float, height: float, *, sliding: bool) -> tuple[float, float]:
    """Bulk tension by a unit of Q where only the left side of a block is held along x, and its bar.

    Q acts on the middle of the top, along x. Of both sides held it is zero.

    Args:
        half_width: of the block.
        height: of the block, whose base is held across.
        sliding: whether the base is free along x.
    """
    shape = half_width / height
    shares, doubt = (SLIDING_SHARES, SLIDING_DOUBT) if sliding else (HELD_SHARES, HELD_DOUBT)
    share = float(np.interp(shape, SHAPES, shares)) * max(1.0, SHAPES[0] / shape)
    doubt *= min(1.0, 1 / shape**2) if sliding else 1.0
    return share / (2 * height), doubt * share / (2 * height)


def _cylinder(values: Mapping[str, float], e_star: float) -> Profile:
    curvature = 1 / values["upper_radius"]
    if values["lower_radius"] > 0:
        curvature += 1 / values["lower_radius"]
    return Hertz(1 / curvature, e_star)


def _wedge(values: Mapping[str, float], e_star: float) -> Profile:
    return Wedge(math.tan(math.radians(values["angle"])), e_star)


def _flat_rounded(values: Mapping[str, float], e_star: float) -> Profile:
    return FlatRounded(values["flat_half_width"], values["radius"], e_star)


PROFILES = {"cylinder": _cylinder, "wedge": _wedge, "flat_rounded": _flat_rounded}


def read_block(template: str, values: Mapping[str, float], case: Case) -> Block:
    """The idealised bodies of a template, one of `PROFILES`, with all its parameters."""
    bodies = case.bodies[UPPER], case.bodies[LOWER]
    e_star = contact_modulus(*bodies, case.model.plane, NORMAL)
    return Block(
        profile=PROFILES[template](values, e_star),
        top_width=2 * values["upper_width"],
        heights=(values["upper_height"], values["lower_height"]),
        half_widths=(values["upper_width"], values["lower_width"]),
        zone=values["zone"],
    )


def geometry_obstacles(case: Case) -> Iterator[str]:
    """Reasons why the geometry of a case is not that of half-planes."""
    template = case.geometry.template
    if template not in PROFILES:
        found = f"a mesh file, {case.geometry.file!r}" if template is None else repr(template)
        yield f"geometry: expected one of the templates {', '.join(PROFILES)}, found {found}"
        return
    if case.geometry.solid is not None:
        yield "geometry.solid: expected a plane case, found a solid"
    if case.geometry.part is not None:
        yield "geometry.part: expected whole bodies, found a part of them"
    if len(case.contacts) > 1:
        yield f"contacts: expected one contact, found {', '.join(case.contacts)}"
    for name, contact in case.contacts.items():
        if (contact.surface1, contact.surface2) != ("upper_contact", "lower_contact"):
            yield (
                f"contacts.{name}: expected surface1 = 'upper_contact' and surface2 = "
                f"'lower_contact', found {contact.surface1!r} and {contact.surface2!r}"
            )
    if set(case.bodies) != {UPPER, LOWER}:
        yield f"bodies: expected {UPPER!r} and {LOWER!r}, found {', '.join(case.bodies)}"
        return
    yield from _crystal_obstacles(case)


def tangential_ratio(case: Case) -> float:
    """Compliance of two half-planes to shear over that to pressure; 1 if isotropic."""
    pair = case.bodies[UPPER], case.bodies[LOWER]
    if all(isotropic(each) for each in pair):
        return 1.0
    (normal, _), (_, tangential) = _compliance(*pair, case.model.plane)
    return float(tangential / normal)


def _compliance(body1: AnyBody, body2: AnyBody, plane: Plane) -> Array:
    """(2, 2) sum of the compliances of both half-planes, normal and tangential."""
    upper, lower = (half_plane(each, plane, FRAME).compliance for each in (body1, body2))
    return np.asarray((upper + lower)[:2, :2])


def _crystal_obstacles(case: Case) -> Iterator[str]:
    """Reasons why crystals are no half-planes with pressure and shear apart from each other."""
    pair = case.bodies[UPPER], case.bodies[LOWER]
    coupled = [name for name in (UPPER, LOWER) if case.bodies[name].couples_across]
    for name in coupled:
        yield (
            f"bodies.{name}.orientation: expected one in which z is normal to a plane of symmetry "
            "of the crystal, because any other one couples displacements in the plane with those "
            "along z"
        )
    if coupled or all(isotropic(each) for each in pair):
        return
    (normal, cross), (_, tangential) = _compliance(*pair, case.model.plane)
    if abs(cross) > ALIKE * normal:
        yield (
            "bodies: expected crystals that yield to pressure and to shear apart from each other, "
            f"found the compliances {normal:.4g} and {tangential:.4g}, and {cross:.2g} of one by "
            "the other: the normal of the surface is no axis of symmetry"
        )
    beta = dissimilarity(*pair, case.model.plane, NORMAL)
    if beta > SIMILAR and any(contact.rough for contact in case.contacts.values()):
        yield (
            "bodies: expected crystals that are elastically similar (Dundurs' beta, generalised, "
            f"up to {SIMILAR:g}), found {beta:.3g}: pressure and shear depend on each other"
        )


def dissimilarity(body1: AnyBody, body2: AnyBody, plane: Plane, normal: Array) -> float:
    """Dundurs' second constant beta; zero if pressure and shear do not interact.

    beta = [mu1 (kappa2 - 1) - mu2 (kappa1 - 1)]/[mu1 (kappa2 + 1) + mu2 (kappa1 + 1)] with
    kappa = 3 - 4 nu in plane strain and (3 - nu)/(1 + nu) in plane stress (Dundurs 1969). Of
    crystals the size of its generalisation, the largest around the normal (d,) in space.
    """
    known1, known2 = isotropic(body1), isotropic(body2)
    if known1 is None or known2 is None:
        both = (half_planes(body, plane, normal) for body in (body1, body2))
        return max(coupling(*each) for each in zip(*both, strict=True))
    first, second = Material.of(known1, plane), Material.of(known2, plane)
    kappa1, kappa2 = first.kolosov, second.kolosov
    mu1, mu2 = first.shear_modulus, second.shear_modulus
    difference = mu1 * (kappa2 - 1) - mu2 * (kappa1 - 1)
    return difference / (mu1 * (kappa2 + 1) + mu2 * (kappa1 + 1))


def coupled_beta(case: Case, contact: str, body1: str, body2: str) -> float:
    """Dundurs' beta of a plane contact in which pressure and shear meet.

    Zero without friction, and of crystals, whose coupling is not counted.
    """
    pair = case.bodies[body1], case.bodies[body2]
    if not case.contacts[contact].rough or not all(isotropic(each) for each in pair):
        return 0.0
    beta = dissimilarity(*pair, case.model.plane, NORMAL)
    return beta if abs(beta) > ROUND_OFF else 0.0


def cross_compliance(body1: AnyBody, body2: AnyBody, plane: Plane, normal: Array) -> float:
    """Displacement that pressure and shear cause of each other over their own; 0 if isotropic.

    |D_nt|/sqrt(D_nn D_tt) with the sum D of the compliances of both half-planes, the larger of both
    directions of shear, the largest around the normal (d,) in space. Unlike beta it is not what
    full stick oscillates by.
    """
    if isotropic(body1) and isotropic(body2):
        return 0.0
    pairs = zip(*(half_planes(each, plane, normal) for each in (body1, body2)), strict=True)
    sums = [first.compliance + second.compliance for first, second in pairs]
    return max(
        abs(each[0, across]) / math.sqrt(each[0, 0] * each[across, across])
        for each in sums
        for across in (1, 2)
    )
