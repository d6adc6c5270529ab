# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of stations that are not told, and why; surfaces that never touch."""

from __future__ import annotations

import math
from dataclasses import asdict, replace

import numpy as np

from fretfe._typing import Array
from fretfe.caution import EDGES
from fretfe.evaluate.contacts import Station
from fretfe.reason import TOLD, Kind, Reason
from fretfe.report.texts import rounded

# Gap over the length of an element up to which chords of a curved surface may have made it: h/(8 R)
# at R = 2.5 h, as coarse as anything round is meshed.
CHORDS = 0.05
# What the parts of the error bar of a range stand for.
PARTS = {
    "extraction": "the radii of the integral disagree",
    "discretisation": "the front is somewhere within an element, or elements along it are long",
    "layer": "the layer gives over a length E*/k that is not short against the half-width",
    "steps": "the shear may go farther between the steps: take more steps per cycle",
    "moved": "the edge moves far within steps, or is not known at an end of them",
    "beside": "what the shear does in states without the edge is unknown",
    "memory": "loads out of phase shear the edge while P moves it, or it moves as no load tells",
}


def withheld(station: Station, *, k_n: bool = True, ranged: bool = True) -> Reason:
    """Reason why K_N or the range of (K_T, K_S) of a station is not told; none if they are.

    Its text is the sentence of warnings, tables, verdicts, first lines and assessments.

    Args:
        station: one.
        k_n: whether K_N is asked for.
        ranged: whether the range is.
    """
    if station.lack.whole:
        return station.lack
    whys = {
        "K_N": k_n_lack(station) if k_n else TOLD,
        f"the range of {_shear(station)}": range_lack(station) if ranged else TOLD,
    }
    names: dict[Reason, list[str]] = {}
    for name, why in whys.items():
        if why:
            names.setdefault(why, []).append(name)
    texts = [f"{' and '.join(own)} unknown, because {why.text}" for why, own in names.items()]
    return replace(next(iter(names)), words="; ".join(texts)) if names else TOLD


def k_n_lack(station: Station) -> Reason:
    """Reason why K_N of a station, of which something is known, is not told."""
    k_n, spread = station.decisive_k_n
    if math.isfinite(station.reported_k_n):
        return TOLD
    if math.isnan(k_n):
        return station.lack or Reason(Kind.NO_FIT)
    return Reason(Kind.WIDE_BAR if math.isfinite(spread) else Kind.NO_BAR)


def range_lack(station: Station) -> Reason:
    """Reason why the range of (K_T, K_S) of a station, of which something is known, is not told."""
    if math.isfinite(station.reported_range):
        return TOLD
    if math.isnan(station.k_range):
        return station.lack or _lost_states(station)
    parts, (size, spread) = asdict(station.k_range_parts), station.driven_range
    if station.moves:
        parts["memory"] = station.equivalent_misheld
    if not math.isfinite(spread):
        lost = " and ".join(name for name, part in parts.items() if not math.isfinite(part))
        words = f"{Kind.NO_BAR.seen} ({lost or 'nothing to compare with'})"
        return Reason(Kind.NO_BAR, words=words)
    # A layer that matters disturbs the other parts, too.
    by_layer = station.k_range_parts.layer > 0.1 * station.k_range
    largest = "layer" if by_layer else max(parts, key=lambda name: parts[name])
    bar = f"it is {with_bar(size, spread)}, an error bar of more than half of it"
    return Reason(Kind.WIDE_BAR, words=f"{bar}: {PARTS.get(largest, largest)}")


def _lost_states(station: Station) -> Reason:
    known = np.isfinite(station.k_t + station.k_s)[: station.last + 1 or None]
    unknown = np.flatnonzero(~known)
    if not len(unknown):
        return Reason(Kind.NO_CYCLE)
    words = f"{_shear(station)} unknown in {len(unknown)} of {len(known)} states, last in state "
    words += f"{unknown[-1]}: {Kind.LOST_STATES.seen}"
    return Reason(Kind.LOST_STATES, len(unknown), len(known), words)


def _shear(station: Station) -> str:
    """Names of the factors of shear: K_T alone at plane edges whose bodies stay in the plane."""
    plane = station.front in EDGES and not np.nan_to_num(station.k_s).any()
    return "K_T" if plane else "K_T and K_S"


def with_bar(value: float, spread: float) -> str:
    """A number with its error bar, in words."""
    return f"{rounded(value)} ± {rounded(spread, 2)}"


def lost_front(place: Array, found: int, wanted: int) -> Reason:
    """The reason where there is no front along a border of the contact.

    Args:
        place: (3,) in the middle of the border.
        found: elements in which the pressure rises from the border to its largest value.
        wanted: elements that would do.
    """
    why = "the pressure falls to zero like a root at too few places of it"
    if found < wanted:
        why = (
            f"the pressure rises to its largest value within {found} "
            f"element{'' if found == 1 else 's'} of it, {wanted} are wanted at least: "
            f"{Reason(Kind.STEEP, found, wanted).advice}"
        )
    at = ", ".join(f"{value:.3g}" for value in place)
    words = f"no front can be followed along this border of the contact, around ({at}): {why}"
    return Reason(Kind.LOST, found, wanted, words)


def untouched_hint(first: float, smallest: float, weights: Array, dimension: int) -> str:
    """Remedy for surfaces that never touch.

    Args:
        first: smallest gap without load.
        smallest: of all states.
        weights: (N,) of nodes.
        dimension: of the bodies.
    """
    spacing = float(np.median(weights)) ** (1 / (dimension - 1))
    if 0 < smallest < CHORDS * spacing:
        return (
            f"That is {smallest / spacing:.1%} of an element: chords of curved surfaces leave such "
            "gaps. Use curved elements (order 2), smaller ones there, or more load"
        )
    if smallest < first:
        return (
            f"The loads bring the bodies together, from a gap of {first:.4g} without them, but not "
            "far enough: check their sizes, or the place of the bodies in the mesh"
        )
    return (
        "No load brings the bodies together: check the signs of those that should, and what holds "
        "the bodies"
    )
