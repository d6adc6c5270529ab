# SPDX-License-Identifier: LGPL-3.0-or-later
"""A case as text that can be run again from any folder."""

from __future__ import annotations

from typing import Any

import tomli_w

from fretfe.case.model import Case
from fretfe.case.reading import load_case
from fretfe.errors import CaseError


def case_text(case: Case) -> str:
    """The case as run, as TOML.

    The text of the case file itself if it says the same and names no files relative to its folder.
    Else the case without comments, the files that it names with their full paths.
    """
    data = _with_full_paths(case)
    if as_written(case) and data == _tables(case):
        return case.source.read_text("utf-8-sig")
    return "# The case as run, written by fretfe.\n" + tomli_w.dumps(data)


def as_written(case: Case) -> bool:
    """Whether the case is what its file says; false if it was not read from a file."""
    try:
        return _tables(load_case(case.source)) == _tables(case)
    except CaseError:
        return False


def _tables(case: Case) -> dict[str, Any]:
    """The keys that are set, as TOML has them."""
    return case.model_dump(mode="json", exclude_unset=True, exclude_none=True)


def _with_full_paths(case: Case) -> dict[str, Any]:
    data = _tables(case)
    geometry = data["geometry"]
    for key in ("file", "facets"):
        if key in geometry:
            geometry[key] = _full(case, geometry[key])
    for load in data.get("loads", {}).values():
        for segment in load["history"]:
            if "csv" in segment:
                segment["csv"] = _full(case, segment["csv"])
    return data


def _full(case: Case, file: str) -> str:
    return str(case.resolve(file).absolute())
