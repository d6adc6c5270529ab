# SPDX-License-Identifier: LGPL-3.0-or-later
"""Companions of a case: another mean, another start, another mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.case import Case, parse_case
from fretfe.loads import History
from fretfe.mesh.templates import find_template
from fretfe.quality.validate.single import CONSTANT_NORMAL
from fretfe.results.model import Result

# The mean moves by this fraction of the range of each load.
MEAN_SHIFT = 0.1
# The other start goes this much beyond the extremes of the cycle.
OVERLOAD = 0.15
# Elements of the other mesh are this much larger: it costs less than half.
COARSER = 1.5
CYCLES = 2
EXCURSION_STEPS = 6


@dataclass(frozen=True)
class Variant:
    """A companion run.

    Attributes:
        name: what it checks.
        case: to solve.
        history: of its loads, None for that of the case.
    """

    name: str
    case: Case
    history: History | None


MEAN, START, MESH = "about another mean", "from another start", "on a coarser mesh"


def make_variants(case: Case, result: Result) -> tuple[list[Variant], dict[str, str]]:
    """The companions of a case that make sense, and for the others the reason why they do not."""
    variants, reasons = [], {}
    if result.loads.cycle is None:
        reasons[MEAN] = reasons[START] = "no cycle to evaluate"
    else:
        if _constant_normal(result):
            variants.append(Variant(MEAN, case, shifted(result.loads)))
        else:
            reasons[MEAN] = "the normal load varies: another mean is another cycle"
        variants.append(Variant(START, case, overloaded(result.loads)))
    coarse = coarser(case)
    if case.edges.tolerance is not None:
        reasons[MESH] = "the mesh refined itself: see the changes from mesh to mesh"
    elif coarse is not None:
        variants.append(Variant(MESH, coarse, None))
    else:
        reasons[MESH] = "a mesh file: compare with a finer mesh of your own"
    if not result.bodies:
        variants = [variant for variant in variants if variant.name != MESH]
        reasons[MESH] = "no mesh"
    return variants, reasons


def _constant_normal(result: Result) -> bool:
    plane = all(
        float(station.k_i_range) <= CONSTANT_NORMAL * float(station.k_t_range)
        for contact in result.contacts
        if not contact.solid
        for station in contact.stations
    )
    # Factors at single stations of solids scatter by about as much as the limit.
    return plane and all(
        np.median(front.along("k_i_range")) <= CONSTANT_NORMAL * np.median(front.along("k_range"))
        for contact in result.contacts
        if contact.solid
        for front in contact.fronts
    )


def shifted(history: History) -> History:
    """The cycle again about a mean that is nearer to zero, or a little higher if it is zero."""
    first, last = _cycle(history)
    loads = history.values[first : last + 1]
    ranges, means = np.ptp(loads, axis=0), (loads.max(axis=0) + loads.min(axis=0)) / 2
    return _continued(history, loads - np.where(means > 0, 1.0, -1.0) * MEAN_SHIFT * ranges)


def overloaded(history: History) -> History:
    """The cycle again after an excursion beyond both of its extremes."""
    first, last = _cycle(history)
    loads = history.values[first : last + 1]
    mean = (loads.max(axis=0) + loads.min(axis=0)) / 2
    larger = mean + (1 + OVERLOAD) * (loads - mean)
    chosen = np.unique(np.linspace(0, len(loads) - 1, 4 * EXCURSION_STEPS + 1).round().astype(int))
    return _continued(history, loads, larger[chosen])


def _cycle(history: History) -> tuple[int, int]:
    assert history.cycle is not None
    return history.cycle


def _continued(history: History, loads: Array, before: Array | None = None) -> History:
    """The history to the start of its cycle, an excursion (k, C), and cycles of loads (n, C)."""
    first, _ = _cycle(history)
    parts = [history.values[: first + 1]]
    parts += [] if before is None else [before]
    parts += [loads] + [loads[1:]] * (CYCLES - 1)
    values = np.vstack(parts)
    step = history.times[-1] / (len(history.times) - 1)
    added = np.arange(1, len(values) - first) * step
    times = np.concatenate([history.times[: first + 1], history.times[first] + added])
    return History(history.channels, times, values, (len(values) - len(loads), len(values) - 1))


def coarser(case: Case) -> Case | None:
    """The same case with larger elements; None where the case does not give their sizes."""
    data = case.model_dump(mode="json", exclude_unset=True)
    if case.geometry.solid is not None:
        layers = max(1, round(case.geometry.solid.layers / COARSER))
        data["geometry"]["solid"]["layers"] = layers
    if case.geometry.size is not None:
        data["geometry"]["size"] = COARSER * case.geometry.size
    elif case.geometry.template is not None:
        given = case.geometry.parameters
        sizes = {
            parameter.name: COARSER * given.get(parameter.name, parameter.default)
            for parameter in find_template(
                case.geometry.template, length=case.units.length
            ).parameters
            if parameter.name.endswith("size")
        }
        data["geometry"]["parameters"] = {**given, **sizes}
    else:
        return None
    return parse_case(data, source=case.source, trust_geo=case.trust_geo)
