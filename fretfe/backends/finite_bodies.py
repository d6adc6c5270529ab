# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error of half-planes in place of finite bodies: in error bars, and as a limit of the model."""

from __future__ import annotations

from dataclasses import replace

from fretfe.edges.front import ContactSummary, Station, fronts_of
from fretfe.edges.limits import ModelLimit
from fretfe.idealise import HalfPlaneProblem

# Error of K_N or K_T from which the factors of half-planes are not those of the bodies.
LARGEST_SIZE_ERROR = 0.01


def with_size_errors(summary: ContactSummary, problem: HalfPlaneProblem) -> ContactSummary:
    """The same contact with error bars that hold the factors of the finite bodies as well."""
    stations = (_wider(station, problem) for station in summary.stations)
    return replace(summary, fronts=fronts_of(stations))


def _wider(station: Station, problem: HalfPlaneProblem) -> Station:
    parts = station.k_t_range_parts
    size = problem.k_t_error * station.k_t_range
    parts = replace(parts, discretisation=parts.discretisation + size)
    return replace(
        station,
        k_n_spread=station.k_n_spread + problem.k_n_error * station.k_n,
        k_t_range_spread=parts.total,
        k_t_range_parts=parts,
    )


def size_limit(contact: str, problem: HalfPlaneProblem) -> ModelLimit:
    """The larger of the errors of K_N and K_T of a contact that the size of the bodies makes."""
    return ModelLimit(
        contact,
        "error of K_N or ΔK_T because the bodies are not half-planes",
        max(problem.k_n_error, problem.k_t_error),
        LARGEST_SIZE_ERROR,
        "the bodies are too low or too narrow for the width of the contact; use the backend 'fem'",
    )
