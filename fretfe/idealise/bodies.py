# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which templates are a profile on a large block, and which materials are similar enough."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from fretfe.analytic.profiles import FlatRounded, Hertz, Profile, Wedge
from fretfe.case import Body, Case, Plane, contact_modulus

UPPER, LOWER = "upper", "lower"
# Dundurs' second constant up to which bodies count as elastically similar. It couples pressure and
# shear: tractions change by about this fraction.
SIMILAR = 0.01
# Less than this is round-off of the constants of equal materials.
ROUND_OFF = 1e-12

# Relative error of a half-plane in place of a body, times the square of the half-width of the
# contact over the height or half-width of the body. Measured by finite elements on cylinders, 3 to
# 10 half-widths high or wide: K_N 0.23 to 0.25 and 0.10 to 0.14, K_T up to 0.1 and 0.3 to 0.7.
K_N_BY_HEIGHT, K_N_BY_WIDTH = 0.25, 0.14
K_T_BY_HEIGHT, K_T_BY_WIDTH = 0.1, 0.7


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

        Args:
            reach: largest half-width of the contact.
        """
        low = sum((reach / height) ** 2 for height in self.heights)
        narrow = sum((reach / half_width) ** 2 for half_width in self.half_widths)
        return (
            K_N_BY_HEIGHT * low + K_N_BY_WIDTH * narrow,
            K_T_BY_HEIGHT * low + K_T_BY_WIDTH * narrow,
        )


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
    e_star = contact_modulus(case.bodies[UPPER], case.bodies[LOWER], case.model.plane)
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


def unlike_obstacles(case: Case) -> Iterator[str]:
    """Reasons why closed forms do not hold for the materials of a case that is half-planes.

    There is no closed form of partial slip between unlike bodies.
    """
    beta = dissimilarity(case.bodies[UPPER], case.bodies[LOWER], case.model.plane)
    if abs(beta) > SIMILAR and any(contact.friction > 0 for contact in case.contacts.values()):
        yield (
            "bodies: expected elastically similar bodies (Dundurs' beta up to "
            f"{SIMILAR:g}), found beta = {beta:.3g}: pressure and shear depend on each other, and "
            "there is no closed form of partial slip; use the backend 'halfplane'"
        )


def dissimilarity(body1: Body, body2: Body, plane: Plane) -> float:
    """Dundurs' second constant beta; zero if pressure and shear do not interact.

    beta = [mu1 (kappa2 - 1) - mu2 (kappa1 - 1)]/[mu1 (kappa2 + 1) + mu2 (kappa1 + 1)] with
    kappa = 3 - 4 nu in plane strain and (3 - nu)/(1 + nu) in plane stress (Dundurs 1969).
    """
    kappa1, kappa2 = (_kolosov(body.poisson, plane) for body in (body1, body2))
    mu1, mu2 = body1.shear_modulus, body2.shear_modulus
    difference = mu1 * (kappa2 - 1) - mu2 * (kappa1 - 1)
    return difference / (mu1 * (kappa2 + 1) + mu2 * (kappa1 + 1))


def coupled_beta(case: Case, contact: str, body1: str, body2: str) -> float:
    """Dundurs' beta of a plane contact in which pressure and shear meet; zero without friction."""
    if case.contacts[contact].friction == 0:
        return 0.0
    beta = dissimilarity(case.bodies[body1], case.bodies[body2], case.model.plane)
    return beta if abs(beta) > ROUND_OFF else 0.0


def _kolosov(poisson: float, plane: Plane) -> float:
    return 3 - 4 * poisson if plane == "strain" else (3 - poisson) / (1 + poisson)
