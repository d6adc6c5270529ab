# SPDX-License-Identifier: LGPL-3.0-or-later
"""Elements that a contact needs: by its solved history, and by its expected width before that.

The normal force follows from the forces on a body that nothing else holds along the contact normal;
the width from the initial gap, as for half-planes with a symmetric profile, or for half-spaces with
a paraboloid. Nothing is said where one of them is not known.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case import Case, unit_vector
from fretfe.case import Contact as ContactTable
from fretfe.case.loads import Push
from fretfe.errors import MeshError
from fretfe.evaluate.contacts import Contact, Front, SlipZone, Station
from fretfe.evaluate.factors import WANTED_NODES
from fretfe.evaluate.plane.section import main_patch, plane_front
from fretfe.evaluate.refinement import SHORTEST_SLIP, StationValues
from fretfe.evaluate.slip import cycle_states
from fretfe.history.solution import ContactHistory, Solution
from fretfe.loads import History
from fretfe.materials.moduli import contact_modulus
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.mesh.sizing import FinePlaces
from fretfe.surface.checks import InitialGap, initial_gaps
from fretfe.surface.surface import Surface, build_surface

# Elements over the length in which the pressure rises, and over a slip zone, in the first mesh that
# resolves a front; each further level halves the elements.
PER_RISE = 16
PER_SLIP_ZONE = 8
# Elements may be larger than asked for by this factor: a mesh follows sizes only roughly.
MISSED = 1.3
# So much smaller are the next elements where these are too large to tell K_N.
BLIND = 4
# Elements over the half-width of the contact below which K_N that is not known will never be.
SMALLEST_ELEMENT = 1e-4
# Slip lengths that are reported and must converge: those of the last loading and unloading.
ZONES = 2
# Error bar of |ΔK| at single stations of solids, times the elements over the half-width of the
# contact, or over the radius of its front: .37 on spheres with 8 and with 12 of them.
BAR_TIMES_ELEMENTS = 0.36
# Elements over the radius of a front below which there is no K_N.
PER_RADIUS = 6.0
# Nodes in contact of solids that are likely to show its fronts.
NODES_WITH_FRONTS = 200
# Elements along fronts of solids become smaller by factors between these from mesh to mesh.
LEAST_FINER = 1.4
MOST_FINER = 2.0
# A direction is along the surface if its part along the normal is below this.
PARALLEL = 1e-3
# The estimate is good to about this fraction of the width: it must not cry wolf.
MARGIN = 0.85
WIDTHS = 400
ANGLES = 64
# A paraboloid is fitted to the gaps within so many half axes and elements around the lowest one, so
# often; it describes them if it misses no more than this part of what they differ by.
REACH = 1.5
ELEMENTS = 2.5
FITS = 8
RESIDUAL = 0.2
# A smaller curvature, as part of the larger one, is none.
STRAIGHT = 1e-6
# Gaps that differ by less than this fraction of the largest one are the same.
SAME_GAP = 1e-6


@dataclass(frozen=True)
class Interval:
    """Places low to high along the arc of a contact that need elements of a size."""

    contact: str
    low: float
    high: float
    size: float


def station_values(solution: Solution, contacts: Sequence[Contact]) -> tuple[StationValues, ...]:
    """Values that must converge, of every contact that carries something when it ends."""
    return tuple(
        StationValues(
            contact=contact.name,
            front=station.front,
            k_n=station.last_k_n[0],
            k_t=_k_t(solution, station),
            slip=tuple(zone.length for zone in _last_zones(station)),
            rise=_rise(history, contact, station),
            friction=station.friction,
        )
        for history, contact, station in _stations(solution, contacts)
    )


def _k_t(solution: Solution, station: Station) -> float:
    """Range of K_T over the cycle; without one that of the worst counted cycle, or the last value.

    The last value of K_T under irregular loads is as good as any.
    """
    if solution.cycle is not None:
        return station.k_range
    cycles = station.cycles
    return float(cycles.k_t_range[cycles.worst] if cycles.irregular else station.k_along[-1])


def _stations(
    solution: Solution, contacts: Sequence[Contact]
) -> Iterator[tuple[ContactHistory, Contact, Station]]:
    for history, contact in zip(solution.contacts, contacts, strict=True):
        if np.any(history.traction[contact.stations[0].last, :, 0] > 0):
            for station in contact.stations:
                if not station.lack.whole:  # no mesh tells anything of those
                    yield history, contact, station


def _last_zones(station: Station) -> tuple[SlipZone, ...]:
    """The last slip zones; those of a contact that slides as a whole have no length."""
    return tuple(zone for zone in station.slip_zones[-ZONES:] if not zone.gross)


def _rise(history: ContactHistory, contact: Contact, station: Station) -> float:
    """Distance in which p = K_N sqrt(s) would rise to the largest pressure on this side.

    Half of the half-width for Hertz; about the length of the rounding in contact for a flat and
    rounded punch. At most the half-width; that of the closed elements while K_N is unknown.
    """
    pressure = history.traction[station.last, :, 0]
    patch = main_patch(history.surface.arc, pressure)
    half_width = float(contact.half_width[station.last])
    if not np.isfinite(station.last_k_n[0]) or not np.isfinite(half_width):
        low, high = max(patch.first - 1, 0), min(patch.last + 1, len(pressure) - 1)
        return float(history.surface.arc[high] - history.surface.arc[low]) / 2
    inside = slice(patch.first, patch.last + 1)
    arc, pressure = history.surface.arc[inside], pressure[inside]
    near = plane_front(station.front).inward * (contact.centre[station.last] - arc) >= 0
    return float(min((pressure[near].max() / station.last_k_n[0]) ** 2, half_width))


def needed_sizes(
    solution: Solution, contacts: Sequence[Contact], level: int
) -> tuple[Interval, ...]:
    """Element sizes that are needed and where; each level halves them."""
    intervals: list[Interval] = []
    for values, (history, contact, station) in zip(
        station_values(solution, contacts), _stations(solution, contacts), strict=True
    ):
        intervals += _station_intervals(solution, history, contact, station, values, 2.0**-level)
    return tuple(intervals)


def fine_places(
    solution: Solution, history: ContactHistory, contact: Contact, tolerance: float
) -> Iterator[FinePlaces]:
    """Places along the fronts of a contact of solids, with the element sizes of the next mesh.

    Those are as small as the tolerance is likely to need, for the half-width at each station, but
    smaller than they were by no more than a factor. Where no front is known all nodes under
    pressure are to be finer, so that there are enough of them.
    """
    cycle = cycle_states(solution.cycle)
    states = cycle if len(cycle) else np.array([len(solution.times) - 1])
    known = [front for front in contact.fronts if front.judged]
    for front in known:
        yield _along(front, states, tolerance)
    pressed = history.traction[int(states[-1]), :, 0] > 0
    if not known and pressed.any():
        count = np.count_nonzero(pressed)
        finer = np.clip(math.sqrt(NODES_WITH_FRONTS / count), MOST_FINER, BLIND)
        size = float(np.sqrt(np.median(history.surface.weights[pressed])) / finer)
        yield FinePlaces(history.surface.points[pressed], np.full(count, size))


def _along(front: Front, states: Indices, tolerance: float) -> FinePlaces:
    """Places along a front, wherever it is in some states; those near its ends aside."""
    stations = front.judged
    before = np.array([station.size for station in stations])
    scale = np.array([np.fmin(station.depth, station.length) for station in stations])
    wanted = np.where(np.isfinite(scale), scale * tolerance / BAR_TIMES_ELEMENTS, 0.0)
    sizes = np.clip(wanted, before / MOST_FINER, before / LEAST_FINER)
    positions = np.nan_to_num([station.position[states] for station in stations])
    low, high = positions.min(axis=1), positions.max(axis=1)
    inward = np.array([station.frame.inward for station in stations])
    points = np.array([station.point for station in stations]) + low[:, None] * inward
    table = np.column_stack([points, (high - low)[:, None] * inward, sizes])
    arc = np.array([station.arc for station in stations])
    count = math.ceil(front.length / sizes.min())
    fine = np.linspace(
        0.0 if front.closed else arc[0], front.length if front.closed else arc[-1], count
    )
    period = front.length if front.closed else None
    rows = np.transpose([np.interp(fine, arc, column, period=period) for column in table.T])
    shares = np.linspace(0.0, 1.0, math.ceil((high - low).max() / sizes.min()) + 1)
    along = [rows[:, :3] + share * rows[:, 3:6] for share in shares]
    return FinePlaces(np.vstack(along), np.tile(rows[:, 6], len(shares)))


def hopeless(solution: Solution, contacts: Sequence[Contact]) -> str:
    """Reason why finer elements will not tell K_N of some edge; empty if they may.

    Where K_N is not known elements become smaller from mesh to mesh by a factor, and would do so
    for ever at an edge that has none: a sharp corner, or the end of a surface.
    """
    for history, contact, station in _stations(solution, contacts):
        if np.isfinite(station.last_k_n[0]) and not station.uncertain:
            continue
        cycle = cycle_states(solution.cycle)
        states = cycle if len(cycle) else np.array([len(solution.times) - 1])
        element = _largest_element(history.surface.arc, *_front_range(history, station, states))
        half_width = float(contact.half_width[station.last])
        scale = half_width if math.isfinite(half_width) else _rise(history, contact, station)
        if element < SMALLEST_ELEMENT * scale:
            return (
                f"K_N at the {station.front} edge of contact {contact.name} is not known with "
                f"elements of {element:.1g} either, {element / scale:.1g} of the half-width: finer "
                "ones will not tell it, as at a sharp corner or at the end of a surface"
            )
    return ""


def resolves(solution: Solution, intervals: Sequence[Interval]) -> bool:
    """True if the elements of the surfaces that carry the tractions are as small as needed."""
    contacts = {contact.name: contact for contact in solution.contacts}
    return all(
        _largest_element(contacts[each.contact].surface.arc, each.low, each.high)
        <= MISSED * each.size
        for each in intervals
    )


def _largest_element(arc: Array, low: float, high: float) -> float:
    # A front may lie at the end of its surface.
    first = min(max(int(np.searchsorted(arc, low, side="right")) - 1, 0), len(arc) - 2)
    last = min(int(np.searchsorted(arc, high, side="left")), len(arc) - 1)
    return float(np.diff(arc[first : max(last, first + 1) + 1]).max())


def _station_intervals(
    solution: Solution,
    history: ContactHistory,
    contact: Contact,
    station: Station,
    values: StationValues,
    refinement: float,
) -> list[Interval]:
    """Range of a station in the cycle and its slip zones; finer where numbers are taken.

    Those places are the station at the end of the cycle, or history, and of half cycles, and the
    inner ends of slip zones; only there do the elements shrink with the level.
    """
    cycle = cycle_states(solution.cycle)
    states = cycle if len(cycle) else np.array([len(solution.times) - 1])
    low, high = _front_range(history, station, states)
    size = values.rise / PER_RISE
    if not np.isfinite(station.last_k_n[0]) or station.uncertain:
        size = min(size, _largest_element(history.surface.arc, low, high) / BLIND)
    front = plane_front(station.front)
    places, intervals = [(float(station.position[station.last]), size)], []
    for zone in _last_zones(station):
        length = _length(zone)
        if length > SHORTEST_SLIP * values.rise:
            position, zone_size = float(station.position[zone.end]), length / PER_SLIP_ZONE
            ends = (position, front.place(position, length))
            intervals.append(Interval(contact.name, min(ends), max(ends), zone_size))
            size = min(size, zone_size)
            places += [(end, min(size, zone_size)) for end in ends]
    intervals.append(Interval(contact.name, low, high, size))
    intervals += [
        Interval(contact.name, place, place, refinement * min(size, own))
        for place, own in places
        if math.isfinite(place)
    ]
    return intervals


def _length(zone: SlipZone) -> float:
    """Length of a slip zone, or what is predicted while the mesh does not resolve it."""
    if zone.resolved and zone.length > 0:
        return zone.length
    return zone.prediction if math.isfinite(zone.prediction) else 0.0


def _front_range(history: ContactHistory, station: Station, states: Indices) -> tuple[float, float]:
    """Range of a station in some states: fitted, or else between the last closed and open nodes."""
    positions = station.position[states]
    if np.isfinite(positions).all():
        return float(positions.min()), float(positions.max())
    arc, front = history.surface.arc, plane_front(station.front)
    places = []
    for state in states:
        if not np.any(history.traction[state, :, 0] > 0):
            continue
        closed = front.outermost(main_patch(arc, history.traction[state, :, 0]))
        opened = np.clip(closed - front.inward, 0, len(arc) - 1)
        places += [arc[opened], arc[closed]]
    return float(min(places)), float(max(places))


def coarse_contacts(case: Case, mesh: Mesh, history: History) -> Iterator[str]:
    """Warnings of contacts that will be too narrow for their elements to be evaluated.

    Args:
        case: of the contacts.
        mesh: its mesh.
        history: its loads.
    """
    for name, initial, normal, force in _pressed(case, mesh, history):
        if force > 0:
            yield from _warning(case, name, initial, normal, force)


def _pressed(
    case: Case, mesh: Mesh, history: History
) -> Iterator[tuple[str, InitialGap, Array, float]]:
    """Each contact with its initial gap, its normal (d,), and its smallest P in the cycle.

    P is that at the end without a cycle, and NaN if equilibrium alone does not give it.
    """
    states = cycle_states(history.cycle)
    for name, initial in initial_gaps(mesh, case).items():
        nearest = int(np.argmin(initial.gap))
        normal = initial.surface2.normals[initial.facet2[nearest]].mean(axis=0)
        normal /= np.linalg.norm(normal)
        force = _normal_force(case, mesh, history, name, initial, normal)
        smallest = np.nan if force is None else force[states if len(states) else [-1]].min()
        yield name, initial, normal, float(smallest)


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
    for name, initial, normal, force in _pressed(case, mesh, history):
        if math.isnan(force):
            reason = "equilibrium alone does not give its normal force"
            yield Proposal(name, force, reason=reason)
        elif force <= 0:
            yield Proposal(name, force, reason="the loads do not press it together all the time")
        else:
            yield _proposal(case, name, initial, normal, force, tolerance)


def _proposal(
    case: Case, name: str, initial: InitialGap, normal: Array, force: float, tolerance: float
) -> Proposal:
    load, carrier = _load(case, initial, normal, force), _carrier(case.contacts[name], initial)
    long, short = _hertz(initial, carrier, normal, load).half_axes
    # At its tips the front of an ellipse is bent more than it is wide: see `range_spread`.
    radius = short**2 / long if math.isfinite(long) else math.inf
    solid = case.geometry.solid
    if not math.isfinite(short) and solid is not None and not solid.skew and not normal[2]:
        # The section of a straight extrusion, as a cylinder with the same growth of its half-width.
        along = initial.points @ [normal[1], -normal[0], 0.0]
        grown = [half_width(along, initial.gap, x * load / solid.length)[0] for x in (1.0, 0.5)]
        short = (grown[0] - grown[1]) / (1 - math.sqrt(0.5))
    if not math.isfinite(short):
        reason = "its gap is neither that of a paraboloid nor of a section with one lowest place"
        return Proposal(name, force, reason=reason)
    size = min(min(short, radius) * tolerance / BAR_TIMES_ELEMENTS, radius / PER_RADIUS)
    return Proposal(name, force, short, float(f"{size:.2g}"))


def _load(case: Case, initial: InitialGap, normal: Array, force: float) -> float:
    """P/E* of a contact."""
    body1, body2 = case.bodies[initial.surface1.body], case.bodies[initial.surface2.body]
    return force / contact_modulus(body1, body2, case.model.plane, normal)


def _warning(
    case: Case, name: str, initial: InitialGap, normal: Array, force: float
) -> Iterator[str]:
    for surface in (initial.surface1, initial.surface2):
        if len(surface.sizes) < 2:
            yield (
                f"contact {name}: the surface of the body {surface.body!r} is a single facet: that "
                f"is no contact surface, {WANTED_NODES} nodes in contact are wanted at least; mesh "
                "it finer, or look for the facets that its physical group lacks"
            )
            return
    load, carrier = _load(case, initial, normal, force), _carrier(case.contacts[name], initial)
    solid = len(normal) == 3
    expected = _across_ellipse if solid else _across_strip
    width, count = expected(initial, carrier, normal, load)
    if not math.isfinite(width):
        return
    if count < MARGIN * WANTED_NODES:
        unit = case.units.length
        size = 2 * width / WANTED_NODES
        yield (
            f"contact {name}: about {count} nodes {'across the' if solid else 'in'} contact "
            f"expected at P = {force:.4g} (half-width {width:.2g} {unit}), {WANTED_NODES} wanted "
            f"at least: make the elements there {size:.1g} {unit} long or less"
        )


def _carrier(contact: ContactTable, initial: InitialGap) -> Surface:
    """The surface that carries the tractions."""
    surfaces = {"surface1": initial.surface1, "surface2": initial.surface2}
    finer = min(surfaces.values(), key=lambda surface: float(np.median(surface.sizes)))
    return surfaces.get(contact.multipliers, finer)


def _across_strip(
    initial: InitialGap, carrier: Surface, normal: Array, load: float
) -> tuple[float, int]:
    """Half-width of a plane contact under P/E*, and the number of nodes in it."""
    tangent = np.array([normal[1], -normal[0]])
    width, centre = half_width(initial.points @ tangent, initial.gap, load)
    return width, int(np.sum(np.abs(carrier.vertices @ tangent - centre) < width))


def _across_ellipse(
    initial: InitialGap, carrier: Surface, normal: Array, load: float
) -> tuple[float, int]:
    """Half of the smallest width of a contact of solids under P/E*, and the nodes across it.

    Infinite where the gap is not that of a paraboloid or of a cylinder.
    """
    found = _hertz(initial, carrier, normal, load)
    width = found.half_axes[1]
    if not np.isfinite(width):
        return np.inf, WANTED_NODES
    from_lowest = _from_lowest(initial, carrier)
    near = from_lowest <= max(width, 2 * float(carrier.sizes[np.argmin(from_lowest)]))
    lengths = np.ptp(carrier.nodes[near] @ found.across, axis=1)
    return float(width), round(2 * width / float(np.median(lengths)))


def hertz_contact(case: Case, name: str, initial: InitialGap, force: float) -> HertzContact | None:
    """A contact of solids by Hertz under P; None where its gap is no paraboloid or cylinder."""
    nearest = int(np.argmin(initial.gap))
    normal = initial.surface2.normals[initial.facet2[nearest]].mean(axis=0)
    normal /= np.linalg.norm(normal)
    carrier = _carrier(case.contacts[name], initial)
    modulus = force / _load(case, initial, normal, force)
    found = _hertz(initial, carrier, normal, force / modulus)
    return replace(found, peak=found.peak * modulus) if math.isfinite(found.half_axes[1]) else None


def _hertz(initial: InitialGap, carrier: Surface, normal: Array, load: float) -> HertzContact:
    """A contact of solids under P/E* as of `expected_contact`, with the direction (3,) across."""
    plane = np.linalg.svd(normal[None])[2][1:]
    places = (initial.points - initial.points[np.argmin(initial.gap)]) @ plane.T
    size = float(carrier.sizes[np.argmin(_from_lowest(initial, carrier))])
    found = expected_contact(places, initial.gap, load, ELEMENTS * size)
    return replace(found, across=found.across @ plane)


def _from_lowest(initial: InitialGap, carrier: Surface) -> Array:
    """(f,) distances of facets from the place of the smallest gap."""
    lowest = initial.points[np.argmin(initial.gap)]
    return np.asarray(np.linalg.norm(carrier.nodes.mean(axis=1) - lowest, axis=1))


@dataclass(frozen=True)
class HertzContact:
    """A contact between half-spaces, or a cylinder between its ends.

    Attributes:
        half_axes: (2,) a >= b; a is infinite of a cylinder, both where the gap is neither.
        across: (2,) direction of b in the tangent plane, (3,) in space.
        peak: largest pressure, over E* if the load is.
    """

    half_axes: Array
    across: Array
    peak: float

    def k_n(self, curvature: float) -> float:
        """K_N = p0 sqrt(2 g) where the front has a curvature g³ a² b² = 1/curvature.

        g is 1/b beside a cylinder. Source: the pressure p0 sqrt(1 - x²/a² - y²/b²) next to its
        border; checked with circles and at the ends of the half axes.
        """
        a, b = self.half_axes
        g = 1 / b if math.isinf(a) else (curvature * (a * b) ** 2) ** (-1 / 3)
        return float(self.peak * math.sqrt(2 * g))


def expected_contact(places: Array, gap: Array, load: float, nearest: float) -> HertzContact:
    """The contact that is expected between half-spaces with an initial gap.

    The gap near its lowest place is taken for a paraboloid. The contact of a cylinder ends where
    the surfaces do: half-planes under the mean force per length.

    Args:
        places: (n, 2) from the lowest one.
        gap: (n,) initial gap there.
        load: P/E*.
        nearest: gaps up to this distance are looked at in any case.
    """
    inside = np.ones(len(gap), dtype=bool)
    missed, none = np.inf, np.full(2, np.inf)
    peak = np.nan
    for _ in range(FITS):
        (x, y), g = places[inside].T, gap[inside]
        terms = np.stack([np.ones_like(x), x, y, x * x / 2, x * y, y * y / 2], axis=1)
        found = np.linalg.lstsq(terms, g, rcond=None)[0]
        missed = np.ptp(g) and np.std(terms @ found - g) / np.std(g)
        curvatures, axes = np.linalg.eigh([[found[3], found[4]], [found[4], found[5]]])
        if curvatures[1] <= 0:
            return HertzContact(none, axes[:, 1], np.nan)
        own = places @ axes
        half_axes = hertz_half_axes(np.maximum(curvatures, STRAIGHT * curvatures[1]), load)
        length, peak = np.ptp(own[:, 0]), 1.5 * load / (np.pi * half_axes.prod())
        if 2 * half_axes[0] > length:
            half_axes = np.array([np.inf, np.sqrt(4 * load / (length * np.pi * curvatures[1]))])
            peak = 2 * load / (np.pi * length * half_axes[1])
        inside = np.sum((own / half_axes) ** 2, axis=1) < REACH**2
        inside |= np.sum(own**2, axis=1) < nearest**2
    return HertzContact(half_axes if missed < RESIDUAL else none, axes[:, 1], float(peak))


def hertz_half_axes(curvatures: Array, load: float) -> Array:
    """(2,) half axes a >= b of the contact of half-spaces with the gap k1 x²/2 + k2 y²/2.

    With e² = 1 - (b/a)² and the complete elliptic integrals K and E of the modulus e,

        k2/k1 = ((a/b)² E - K) / (K - E),    a³ = 3 (P/E*) E / (pi (b/a)² (k1 + k2))

    Source: Hertz; K. L. Johnson, Contact Mechanics, section 4.2. Valid for elastic bodies without
    friction, or of equal elastic constants, and axes that are small against the radii.

    Args:
        curvatures: (2,) 0 < k1 <= k2.
        load: P/E*.
    """
    # Imported where it is needed: SciPy's functions take a tenth of a second.
    from scipy.optimize import brentq
    from scipy.special import ellipe, ellipkm1

    def excess(logarithm: float) -> float:
        t = np.exp(2 * logarithm)
        first, second = ellipkm1(t), ellipe(1 - t)
        return float((second / t - first) / (first - second) - curvatures[1] / curvatures[0])

    circle = -1e-6  # of log(b/a): nearer to a circle both differences are round-off
    logarithm = brentq(excess, -12.0, circle) if excess(circle) < 0 else 0.0
    t = np.exp(2 * logarithm)
    a = np.cbrt(3 * load * ellipe(1 - t) / (np.pi * t * curvatures.sum()))
    return np.array([a, a * np.exp(logarithm)])


def half_width(along: Array, gap: Array, force: float) -> tuple[float, float]:
    """Half-width of the contact, infinite if it is wider than the surfaces, and its centre.

    Infinite, too, where the gap is lowest in several places apart, as of a pad with two bumps: how
    many of them share the force is not known before.

    With the gap g(x) made even about its lowest place, P/E* = a ∫ g'(a sin t) sin t dt over
    0 < t < pi/2 (half-planes).

    Args:
        along: (n,) places along the surface.
        gap: (n,) initial gap there.
        force: P/E*.
    """
    order = np.argsort(along)
    x, g = along[order], gap[order] - gap.min()
    centre = float(x[g <= SAME_GAP * g.max()].mean()) if g.max() > 0 else float(x.mean())
    widest = min(centre - x[0], x[-1] - centre)
    if widest <= 0:  # lowest at an end, behind which nothing is known
        return np.inf, centre
    widths = np.linspace(0.0, widest, WIDTHS + 1)[1:]
    even = (np.interp(centre + widths, x, g) + np.interp(centre - widths, x, g)) / 2
    if even.min() < np.interp(centre, x, g) - SAME_GAP * g.max():
        return np.inf, centre
    slopes = np.diff(even, prepend=0.0) / widths[0]
    angles = (np.arange(ANGLES) + 0.5) * np.pi / 2 / ANGLES
    at = widths[:, None] * np.sin(angles)
    steps = np.minimum((at / widths[0]).astype(int), WIDTHS - 1)
    forces = widths * (slopes[steps] * np.sin(angles)).mean(axis=1) * np.pi / 2
    if force >= forces[-1]:
        return np.inf, centre
    return float(np.interp(force, np.maximum.accumulate(forces), widths)), centre


def _normal_force(
    case: Case, mesh: Mesh, history: History, contact: str, initial: InitialGap, normal: Array
) -> Array | None:
    """(T,) normal force P per unit thickness; None if equilibrium alone does not give it."""
    if any(each.body_force for each in case.loads.values()):
        return None
    for surface, sign in ((initial.surface1, -1.0), (initial.surface2, 1.0)):
        own = mesh.bodies[surface.body].boundaries
        others = [
            each for name, each in case.contacts.items()
            if name != contact and {each.surface1, each.surface2} & set(own)
        ]  # fmt: skip
        if not others and not _held(case, set(own), normal):
            return sign * _force(case, mesh, history, surface.body) @ normal
    return None


def _held(case: Case, own: set[str], normal: Array) -> bool:
    """True if anything but forces moves or holds a body with these boundaries along the normal."""
    if any(sector.boundary1 in own for sector in case.symmetry.values()):
        return True
    normal = np.append(normal, 0.0)[:3]
    held = [
        unit_vector(axis, 3)
        for support in case.supports.values()
        if support.boundary in own
        for axis in support.fix
    ]
    platens: dict[str, Array] = {}
    for load in case.loads.values():
        if load.on not in own or not (load.moves or load.rigid):
            continue
        if load.by_shape:
            return True
        free = platens.get(load.on, normal)
        if load.along is not None:
            direction = np.array(unit_vector(load.along, 3))
            free = free - (free @ direction) * direction
            if load.push is None:
                held.append(tuple(direction))
        if load.rigid:
            platens[load.on] = free
    # What is left of the normal is a direction in which a platen is guided.
    directions = [*map(np.array, held), *platens.values()]
    return any(abs(float(normal @ direction)) > PARALLEL for direction in directions)


def _force(case: Case, mesh: Mesh, history: History, body: str) -> Array:
    """(T, d) sum of the forces on a body, in the plane per unit thickness."""
    total = np.zeros((len(history.times), mesh.dimension))
    own = mesh.bodies[body].boundaries
    for name, load in case.loads.items():
        if load.push is None or load.on not in own:
            continue
        force = (
            np.array(unit_vector(load.push.direction, 3)[: mesh.dimension]) / case.model.thickness
            if load.push.total
            else _resultant(load.push, mesh.bodies[body], load.on)
        )
        total += np.outer(history.values[:, history.channels.index(name)], force)
    return total


def _resultant(push: Push, body: BodyMesh, boundary: str) -> Array:
    """(d,) force of a unit traction; NaN if it varies, or its boundary is no single surface."""
    dimension = body.points.shape[1]
    if not push.uniform:
        return np.full(dimension, np.nan)
    try:
        surface = build_surface(body, boundary)
    except MeshError:
        return np.full(dimension, np.nan)
    if push.direction == "normal":
        return np.asarray(surface.measures @ surface.normals.mean(axis=1))
    return surface.measures.sum() * np.array(unit_vector(push.direction, 3)[:dimension])
