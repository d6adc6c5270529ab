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


@dataclass(frozen=True)
class Block:
    """What remains of a template: its profile and how large its bodies are.

    Attributes:
        profile: initial gap between the bodies.
        top_width: full width of the upper body's top.
        height: of that top above the contact.
        lower_height: of the lower body.
        smallest: smallest of the half-widths and heights of both bodies.
        zone: half-width of the candidate contact zone.
    """

    profile: Profile
    top_width: float
    height: float
    lower_height: float
    smallest: float
    zone: float


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
    sizes = ("upper_width", "upper_height", "lower_width", "lower_height")
    return Block(
        profile=PROFILES[template](values, e_star),
        top_width=2 * values["upper_width"],
        height=values["upper_height"],
        lower_height=values["lower_height"],
        smallest=min(values[size] for size in sizes),
        zone=values["zone"],
    )


def geometry_obstacles(case: Case) -> Iterator[str]:
    """Why the geometry or the materials of a case are not those of similar half-planes."""
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
        return
    beta = dissimilarity(case.bodies[UPPER], case.bodies[LOWER], case.model.plane)
    if abs(beta) > SIMILAR and any(contact.friction > 0 for contact in case.contacts.values()):
        yield (
            "bodies: expected elastically similar bodies (Dundurs' beta up to "
            f"{SIMILAR:g}), found beta = {beta:.3g}: pressure and shear depend on each other"
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


def _kolosov(poisson: float, plane: Plane) -> float:
    return 3 - 4 * poisson if plane == "strain" else (3 - poisson) / (1 + poisson)
