# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts as they are expected before anything is solved, and the elements that they need.

The normal force follows from equilibrium (`contact_force`), edges and pressure from the initial
gap, as for half-planes, or for half-spaces with a paraboloid. Nothing is said where one of them is
not known.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from operator import attrgetter

import numpy as np

from fretfe._typing import Array
from fretfe.analytic.hertz import HertzContact, expected_contact
from fretfe.analytic.strip import StripContact, strip_contact
from fretfe.bodies.contact_force import ContactForces, contact_normal
from fretfe.bodies.free_ends import rounded_down
from fretfe.case import Case
from fretfe.errors import ModelError
from fretfe.evaluate.contacts import LARGEST_SPREAD
from fretfe.evaluate.edge_zone import EdgeZone, rise_length
from fretfe.evaluate.limits import DOUBTED
from fretfe.evaluate.plane.section import PLANE_FRONTS
from fretfe.evaluate.resolution import BAR_TIMES_ELEMENTS, MISSED
from fretfe.evaluate.slip import cycle_states
from fretfe.loads import History
from fretfe.materials.moduli import contact_modulus
from fretfe.mesh.load import section_of, size_key
from fretfe.mesh.mesh import Mesh
from fretfe.mesh.sizing import FinePlaces
from fretfe.report.texts import rounded
from fretfe.surface.checks import InitialGap, initial_gaps
from fretfe.surface.surface import Surface

# Elements over the radius of a front below which there is no K_N.
PER_RADIUS = 6.0
# Pressures of contacts that share a load tilt: the rise is .45 to .65 of that of even ones at the
# upper ends of flanks of dovetails, .8 to 1.1 of it in firtrees.
TILTED = 0.5
# Gaps within so many elements of the lowest one are looked at in any case.
ELEMENTS = 2.5


@dataclass(frozen=True)
class ExpectedContact:
    """A contact under loads that are known, or guessed, before anything is solved.

    Attributes:
        case: of the contact.
        name: of it.
        initial: its gap.
        forces: smallest and largest P in the cycle, or at the end without one; NaN if unknown.
        shared: whether they are guessed, of contacts that share a load.
        middle: (2,) where a half model goes on behind a plane of symmetry; None if it does not.
    """

    case: Case
    name: str
    initial: InitialGap
    forces: tuple[float, float]
    shared: bool = False
    middle: Array | None = None

    @cached_property
    def normal(self) -> Array:
        """(d,) unit normal of surface 2 where the gap is smallest."""
        return contact_normal(self.initial)

    @property
    def foreseen(self) -> bool:
        """True if P is known, presses, and closes the gap of the mesh alone."""
        return self.forces[0] > 0 and self.case.contacts[self.name].gap is None

    @property
    def tilted(self) -> ExpectedContact:
        """The same down to the smallest P that edges of contacts which share a load feel.

        The rise at a rounding goes with P^(2/3).
        """
        low, high = self.forces
        return replace(self, forces=(TILTED**1.5 * low if self.shared else low, high), shared=False)

    @property
    def modulus(self) -> float:
        """E* of both bodies across the contact."""
        bodies, initial = self.case.bodies, self.initial
        body1, body2 = bodies[initial.surface1.body], bodies[initial.surface2.body]
        return contact_modulus(body1, body2, self.case.model.plane, self.normal)

    @cached_property
    def carrier(self) -> Surface:
        """The surface that carries the tractions."""
        surfaces = {"surface1": self.initial.surface1, "surface2": self.initial.surface2}
        finer = min(surfaces.values(), key=lambda surface: float(np.median(surface.sizes)))
        return surfaces.get(self.case.contacts[self.name].multipliers, finer)

    @cached_property
    def across(self) -> tuple[Array, float] | None:
        """Direction (d,) of the arc of a section, and the length behind it; None without any."""
        if len(self.normal) == 2:
            return np.array([self.normal[1], -self.normal[0]]), 1.0
        sweep = section_of(self.case)
        if sweep is None:
            return None
        direction = np.cross(self.normal, sweep.direction)
        length = sweep.solid.shared(self.initial.surface1.body, self.initial.surface2.body)
        length *= float(np.linalg.norm(sweep.direction))
        return direction / np.linalg.norm(direction), length

    def section(self, force: float) -> tuple[Array, Array, float] | None:
        """Places (n,) across, gaps (n,) there, and P/E* per length; None without a section."""
        if self.across is None:
            return None
        direction, length = self.across
        along, gap = self.initial.points @ direction, self.initial.gap
        load = force / length / self.modulus
        if self.middle is None:
            return along, gap, load
        twice = 2 * float(self.middle @ direction)  # the image carries as much
        return np.append(along, twice - along), np.append(gap, gap), 2 * load

    def strip(self, force: float) -> StripContact | None:
        """The section of the contact under P; None if it is not known."""
        found = self.section(force)
        return None if found is None else strip_contact(*found)

    def hertz(self, force: float) -> HertzContact:
        """A contact of solids under P, over E* as of `expected_contact`, with (3,) across."""
        plane = np.linalg.svd(self.normal[None])[2][1:]
        points, gap = self.initial.points, self.initial.gap
        places = (points - points[np.argmin(gap)]) @ plane.T
        size = float(self.carrier.sizes[np.argmin(self._from_lowest)])
        found = expected_contact(places, gap, force / self.modulus, ELEMENTS * size)
        return replace(found, across=found.across @ plane)

    @property
    def _from_lowest(self) -> Array:
        """(f,) distances of facets of the carrier from the place of the smallest gap."""
        lowest = self.initial.points[np.argmin(self.initial.gap)]
        return np.asarray(np.linalg.norm(self.carrier.nodes.mean(axis=1) - lowest, axis=1))

    def edges(self) -> Iterator[ExpectedEdge]:
        """Edges under the smallest and the largest P, as far as the gap tells them."""
        for force in dict.fromkeys(self.forces):
            if self.across is None:
                yield from self._front(force)
            elif (strip := self.strip(force)) is not None:
                for front, place, peak, k_n in zip(
                    PLANE_FRONTS, strip.edges, strip.peaks, strip.k_n, strict=True
                ):
                    rise = rise_length(peak, k_n, strip.half_width)
                    element = self._element(place, place + front.inward * rise)
                    if element > 0:
                        shortest = TILTED if self.shared else 1.0
                        zone = EdgeZone(rise, element, len(self.normal), shortest)
                        width = strip.half_width
                        yield ExpectedEdge(self.name, front.name, force, width, zone, place)

    def _element(self, begin: float, end: float) -> float:
        """Median length across a section of facets between two places; 0 beyond the surface."""
        assert self.across is not None
        places = self.carrier.nodes @ self.across[0]
        low, high = places.min(axis=1), places.max(axis=1)
        there = (high > min(begin, end)) & (low < max(begin, end))
        inside = low.min() < begin < high.max()
        return float(np.median((high - low)[there])) if inside else 0.0

    def _front(self, force: float) -> Iterator[ExpectedEdge]:
        """The front of a paraboloid or a cylinder of solids, across its smaller half axis."""
        found = self.hertz(force)
        width = float(found.half_axes[1])
        if not math.isfinite(width):
            return
        from_lowest = self._from_lowest
        near = from_lowest <= max(width, 2 * float(self.carrier.sizes[np.argmin(from_lowest)]))
        lengths = np.ptp(self.carrier.nodes[near] @ found.across, axis=1)
        zone = EdgeZone(width / 2, float(np.median(lengths)), 3)
        yield ExpectedEdge(self.name, "front", force, width, zone)


@dataclass(frozen=True)
class ExpectedEdge:
    """An edge, or a front of solids, as it is expected.

    Attributes:
        contact: whose it is.
        name: which of its edges.
        force: P.
        half_width: of the contact, or the smaller half axis.
        zone: the rise of the pressure there, and the elements.
        place: along a section; NaN without one.
    """

    contact: str
    name: str
    force: float
    half_width: float
    zone: EdgeZone
    place: float = math.nan


def expected_contacts(
    case: Case, mesh: Mesh, history: History, middles: Mapping[str, Array] | None = None
) -> Iterator[ExpectedContact]:
    """The contacts of a case, with their forces by equilibrium or as they are guessed.

    Args:
        case: of the contacts.
        mesh: its mesh, of any element size that shows the gap.
        history: its loads.
        middles: (2,) of contacts in the plane of which the model has a half, by name.
    """
    forces = ContactForces(case, mesh, history)
    cycle = cycle_states(history.cycle)
    states = cycle if len(cycle) else np.array([len(history.times) - 1])
    for name, initial in initial_gaps(mesh, case).items():
        found = forces.exact(name)
        if shared := found is None:
            found = forces.guessed(name, states)
        own = np.full(1, np.nan) if found is None else found[states]
        bounds = float(own.min()), float(own.max())
        yield ExpectedContact(case, name, initial, bounds, shared, (middles or {}).get(name))


def expected_places(case: Case, mesh: Mesh, history: History) -> FinePlaces:
    """Places of plane bodies at the edges that are expected of contacts, with the sizes they need.

    Args:
        case: of the contacts.
        mesh: its plane mesh.
        history: loads.
    """
    points, sizes = [np.empty((0, 2))], [np.empty(0)]
    for contact in expected_contacts(case, mesh, history):
        if not contact.foreseen or contact.across is None:
            continue
        along = contact.initial.points @ contact.across[0]
        order = np.argsort(along)
        edges = sorted(contact.tilted.edges(), key=attrgetter("name", "place"))
        for _, own in groupby(edges, key=attrgetter("name")):
            zones = np.array([(edge.place, edge.zone.size) for edge in own])
            places = _spaced(zones[0, 0], zones[-1, 0], zones.T)
            columns = [np.interp(places, along[order], x) for x in contact.initial.points[order].T]
            points.append(np.transpose(columns))
            sizes.append(np.interp(places, *zones.T))
    return FinePlaces(np.pad(np.vstack(points), ((0, 0), (0, 1))), np.concatenate(sizes))


def _spaced(low: float, high: float, sizes: Array) -> Array:
    """Places from low to high that are as far apart as sizes, given at places (2, n), are large."""
    found = [low]
    while found[-1] < high:
        found.append(found[-1] + float(np.interp(found[-1], *sizes)))
    return np.array(found)


def require_pressed(case: Case, mesh: Mesh, history: History) -> None:
    """Check that loads press every contact at some time, where equilibrium gives its force.

    Raises:
        ModelError: names the first that they do not.
    """
    for name, bodies, force in _in_equilibrium(case, mesh, history):
        if force.max() <= 0.0:
            found = f"loads that pull them apart all the time, by up to {rounded(-force.min())}"
            remedy = "turn them round"
            if force.min() == 0.0:
                found = "that P is 0 all the time, as nothing else holds or presses one of them"
                remedy = "support it, or load it"
            expected = f"contact {name}: expected loads that press {bodies} together"
            raise ModelError(f"{expected}, found {found}: {remedy}")


def pulled_off(case: Case, mesh: Mesh, history: History, state: int) -> str:
    """Contacts that loads do not press together in a state, in words; empty without any."""
    return " ".join(
        f"By equilibrium P of contact {name} is {rounded(force[state])} at t = "
        f"{history.times[state]:g}: nothing keeps {bodies} together. End the history before that, "
        "or hold them by a support or a displacement."
        for name, bodies, force in _in_equilibrium(case, mesh, history)
        if force[state] <= 0.0
    )


def _in_equilibrium(case: Case, mesh: Mesh, history: History) -> Iterator[tuple[str, str, Array]]:
    """Contacts whose force (T,) equilibrium gives, with the names of their bodies."""
    if case.geometry.part is not None:  # the run that drives it had contact
        return
    forces = ContactForces(case, mesh, history)
    for name, initial in initial_gaps(mesh, case).items():
        facing = initial.surface2.normals[initial.facet2] @ contact_normal(initial)
        force = forces.exact(name)
        # around a shaft forces along the normal say nothing
        if force is not None and facing.min() > 0.0:
            yield name, f"{initial.surface1.body!r} and {initial.surface2.body!r}", force


def coarse_contacts(
    case: Case,
    mesh: Mesh,
    history: History,
    middles: Mapping[str, Array] | None = None,
    *,
    advise: bool = True,
) -> Iterator[str]:
    """Warnings of contacts whose elements are too large for what happens at their edges.

    Args:
        case: of the contacts.
        mesh: its mesh.
        history: its loads.
        middles: as of `expected_contacts`.
        advise: whether they say which elements are wanted.
    """
    expected = [each for each in expected_contacts(case, mesh, history, middles) if each.foreseen]
    for each in expected:
        for surface in (each.initial.surface1, each.initial.surface2):
            if len(surface.sizes) < 2:
                yield (
                    f"contact {each.name}: the surface of the body {surface.body!r} is a single "
                    "facet: that is no contact surface; mesh it finer, or look for facets that its "
                    "physical group lacks"
                )
    whole = [each for each in expected if len(each.carrier.sizes) > 1]
    coarse = [edge for each in whole for edge in each.edges() if edge.zone.coarse]
    if coarse:
        yield _coarse_edges(case, coarse) + (_remedy(case, coarse) if advise else "")


def _coarse_edges(case: Case, coarse: Sequence[ExpectedEdge]) -> str:
    """Edges whose elements are too large, in words, and why at the worst of them."""
    worst, unit = min(coarse, key=lambda edge: edge.zone.elements), case.units.length
    names = {
        contact: " and ".join(dict.fromkeys(edge.name for edge in own))
        for contact, own in groupby(coarse, key=attrgetter("contact"))
    }
    where = ", ".join(f"contact {name} ({own})" for name, own in names.items())
    return (
        f"{where}: K_N is likely to be unknown, or known to less than {LARGEST_SPREAD:.0%}: at P = "
        f"{worst.force:.4g} (half-width {worst.half_width:.2g} {unit}) the pressure of "
        f"{worst.contact}, {worst.name}, rises within {worst.zone.rise:.2g} {unit}, over "
        f"{worst.zone.elements:.1f} elements, {worst.zone.wanted} are wanted"
    )


def _remedy(case: Case, coarse: Sequence[ExpectedEdge]) -> str:
    """Element size with which the edges will have K_N, in words.

    A key is changed in proportion, which helps where the elements are those that it asks for.
    """
    key, now = size_key(case)
    if not key:
        finest = min(edge.zone.size for edge in coarse)
        return f": make the elements there {rounded_down(finest):g} {case.units.length} long"
    if (largest := max(edge.zone.element for edge in coarse)) > MISSED * now:
        return (
            f"; elements there are {largest:.2g} {case.units.length} long, as those of {key} end "
            "before: have the fine mesh reach farther, or give edges.tolerance in place of sizes"
        )
    size = min(now * edge.zone.size / edge.zone.element for edge in coarse)
    return f": set {key} = {rounded_down(size):g}, or give edges.tolerance in place of sizes"


def pressure_doubts(
    case: Case, mesh: Mesh, history: History, middles: Mapping[str, Array] | None = None
) -> Iterator[str]:
    """Plane contacts whose mean pressure no material bears: a unit is likely to be wrong.

    Arguments as of `expected_contacts`.
    """
    for each in expected_contacts(case, mesh, history, middles) if mesh.dimension == 2 else ():
        section = each.section(force := each.forces[0])
        if not each.foreseen or case.contacts[each.name].layer is not None or section is None:
            continue
        along, _, load = section
        strip = each.strip(force)
        mean = load / min(2 * strip.half_width if strip else math.inf, float(np.ptp(along)))
        if mean > DOUBTED[1]:
            surfaces = each.initial.surface1, each.initial.surface2
            yield (
                f"contact {each.name}: P = {rounded(force)} means a pressure of {rounded(mean, 2)} "
                "E* or more, where fretting contacts have 1e-4 to 1e-2: check "
                f"{' and '.join(f'bodies.{surface.body}' for surface in surfaces)}, which are in "
                f"{case.units.stress}, and the loads on them"
            )


@dataclass(frozen=True)
class Proposal:
    """Element size at the fronts of a contact of solids that a tolerance is likely to need.

    Attributes:
        contact: name.
        force: smallest P in the cycle.
        length: half-width expected there; of a rounding the one that grows as fast with P.
        size: of the elements; NaN where it is not known.
        reason: why it is not.
    """

    contact: str
    force: float
    length: float = math.nan
    size: float = math.nan
    reason: str = ""


def proposed_sizes(
    case: Case, mesh: Mesh, history: History, tolerance: float
) -> Iterator[Proposal]:
    """For each contact of solids the element size that K_N and |ΔK| are likely to need.

    Args:
        case: of the contacts.
        mesh: its mesh, of any element size that shows the gap.
        history: its loads.
        tolerance: wanted relative error bar at all stations.
    """
    for each in expected_contacts(case, mesh, history):
        force, reason = each.forces[0], ""
        if math.isnan(force):
            reason = "equilibrium does not give its normal force"
        elif force <= 0:
            reason = "the loads do not press it together all the time"
        elif not each.foreseen:
            reason = "it has a gap of its own"
        if reason:
            yield Proposal(each.name, force, reason=reason)
        else:
            yield _proposal(each, force, tolerance)


def _proposal(contact: ExpectedContact, force: float, tolerance: float) -> Proposal:
    long, short = contact.hertz(force).half_axes
    # At its tips the front of an ellipse is bent more than it is wide: see `range_spread`.
    radius = short**2 / long if math.isfinite(long) else math.inf
    if not math.isfinite(short) and (strip := contact.strip(force)) is not None:
        # The section of a straight extrusion, as a cylinder with the same growth of its half-width.
        short = 2 * float(strip.growth.min())
    if not math.isfinite(short):
        reason = "its gap is neither that of a paraboloid nor of a section with one lowest place"
        return Proposal(contact.name, force, reason=reason)
    size = min(min(short, radius) * tolerance / BAR_TIMES_ELEMENTS, radius / PER_RADIUS)
    return Proposal(contact.name, force, short, float(f"{size:.2g}"))


def hertz_contact(case: Case, name: str, initial: InitialGap, force: float) -> HertzContact | None:
    """A contact of solids by Hertz under P; None where its gap is no paraboloid or cylinder."""
    contact = ExpectedContact(case, name, initial, (force, force))
    found = contact.hertz(force)
    known = math.isfinite(found.half_axes[1])
    return replace(found, peak=found.peak * contact.modulus) if known else None
