# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fretting contacts: edge factors K_N and K_T and slip zones of two-body contacts.

``load_case``, ``run``, ``load_result`` and others are those of `fretfe.api`, which is imported when
one of them is used: importing the package alone is quick.
"""

from __future__ import annotations

import importlib

TYPE_CHECKING = False  # that of typing takes a while
if TYPE_CHECKING:
    from fretfe.api import (
        Case,
        Comparison,
        Observer,
        Points,
        Result,
        Sweep,
        assess,
        check,
        compare,
        compare_tests,
        export,
        load_case,
        load_result,
        load_rig,
        make_mesh,
        match_test,
        plot_comparison,
        plot_factors,
        plot_loads,
        plot_scatter,
        plot_strength,
        plot_tornado,
        plot_tractions,
        run,
        sample,
        strength_map,
        sweep,
        validate,
        verify,
        write_submodel,
    )

    __version__: str

__all__ = (
    "Case",
    "Comparison",
    "Observer",
    "Points",
    "Result",
    "Sweep",
    "assess",
    "check",
    "compare",
    "compare_tests",
    "export",
    "load_case",
    "load_result",
    "load_rig",
    "make_mesh",
    "match_test",
    "plot_comparison",
    "plot_factors",
    "plot_loads",
    "plot_scatter",
    "plot_strength",
    "plot_tornado",
    "plot_tractions",
    "run",
    "sample",
    "strength_map",
    "sweep",
    "validate",
    "verify",
    "write_submodel",
)

if not TYPE_CHECKING:  # else each misspelt name would have a type

    def __getattr__(name: str) -> object:
        if name == "__version__":
            from importlib.metadata import version

            return version("fretfe")
        if name not in __all__:
            raise AttributeError(f"module 'fretfe' has no attribute {name!r}")
        return getattr(importlib.import_module("fretfe.api"), name)


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
