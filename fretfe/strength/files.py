# SPDX-License-Identifier: LGPL-3.0-or-later
"""A strength map as JSON and as a figure in a folder."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from fretfe.errors import OutputError
from fretfe.results.files import disk_reason, replace_text
from fretfe.results.writer import prepare_other
from fretfe.strength.figure import write_strength
from fretfe.strength.fit import COVERAGE, LifeFit
from fretfe.strength.margins import Margin, StrengthMap

SCHEMA = {"name": "fretfe-strength", "version": 1}
# Attributes of an edge and of its margin, which are keys of the file.
OF_EDGE = (
    "result", "contact", "edge", "station", "k_n", "k_n_spread", "k_t_range",
    "k_t_range_spread", "friction",
)  # fmt: skip
JUDGED = ("strength", "margin", "low", "high", "fit_share", "scatter_share", "edge_share")
STRENGTH, PICTURE = "strength.json", "strength.png"


def strength_numbers(found: StrengthMap) -> dict[str, Any]:
    """The map in the types of JSON; null for what is unknown."""
    fits = found.fits
    tests = found.tests
    return {
        "schema": SCHEMA,
        "tests": {
            "file": str(tests.path),
            "count": len(tests.life),
            "runouts": int(tests.runout.sum()),
        },
        "units": {"length": tests.units.length, "stress": tests.units.stress},
        "life": found.life,
        "coverage": COVERAGE,
        "fits": [_fit(each) for each in fits],
        "edges": [_edge(each, fits) for each in found.margins],
        "without_edges": list(found.without_edges),
    }


def write_map(found: StrengthMap, folder: Path) -> tuple[Path, ...]:
    """Write `strength.json` and `strength.png` into a folder, made if missing.

    Raises:
        CaseError: if the folder holds results of a run.
        OutputError: if a file cannot be written.
    """
    prepare_other(folder)
    try:
        text = json.dumps(strength_numbers(found), indent=1, allow_nan=False)
        replace_text(folder / STRENGTH, text + "\n")
        write_strength(found, folder / PICTURE)
    except OSError as error:
        raise OutputError(f"{folder}: cannot write the map: {disk_reason(error)}") from error
    return folder / STRENGTH, folder / PICTURE


def _fit(fit: LifeFit) -> dict[str, Any]:
    return {
        "coefficients": fit.coefficients.tolist(),
        "covariance": fit.covariance.tolist(),
        "scatter": fit.scatter,
        "failures": fit.failures,
        "runouts": fit.runouts,
        "quantile": fit.quantile,
    }


def _edge(margin: Margin, fits: tuple[LifeFit, ...]) -> dict[str, Any]:
    edge = margin.edge
    place = next((n for n, each in enumerate(fits) if each is margin.fit), None)
    return {
        **{name: _plain(getattr(edge, name)) for name in OF_EDGE},
        "tests": margin.tests,
        "fit": place,
        **{name: _plain(getattr(margin, name)) for name in JUDGED},
        "reason": margin.reason,
        "remarks": list(edge.remarks),
    }


def _plain(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
