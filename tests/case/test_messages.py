# SPDX-License-Identifier: LGPL-3.0-or-later
"""Unknown keys in any table of a case: the message has the keys of that table."""

from __future__ import annotations

from typing import Any

import pytest
from cases.pad_cases import pad

from fretfe.case import parse_case
from fretfe.errors import CaseError

WAVE = {"wave": "sine", "amplitude": 1.0, "period": 1.0, "cycles": 1, "steps_per_cycle": 8}


def placed(path: str, table: dict[str, Any]) -> dict[str, Any]:
    """The tables of a case with another one at a path."""
    tables = inner = pad()
    *above, last = path.split(".")
    for key in above:
        inner = inner.setdefault(key, {})
    inner[last] = table
    return tables


@pytest.mark.parametrize(
    ("path", "table", "other"),
    [
        ("start", {"from": "run", "time": 1.0}, "from"),
        ("units", {}, "length"),
        ("model", {}, "plane"),
        ("geometry.solid", {"length": 1.0, "layers": 2}, "skew"),
        ("geometry.part", {"centre": [0.0, 0.0], "radius": 1.0}, "radius"),
        ("geometry.bodies.a", {"label": "a"}, "points"),
        ("bodies.upper", {"young": 1e5, "poisson": 0.3}, "young"),
        ("contacts.main.layer", {"normal": 1e5, "tangential": 1e5}, "normal"),
        ("contacts.main.friction", {"times": [0.0, 1.0], "values": [0.1, 0.2]}, "values"),
        ("supports.base", {"boundary": "lower_bottom", "fix": ["x"]}, "direction"),
        ("symmetry.all", {}, "axis"),
        ("ties.all", {}, "boundary1"),
        ("cycle", {}, "more"),
        ("edges", {}, "tolerance"),
        ("output", {}, "fields"),
    ],
)
def test_an_unknown_key_is_told_with_those_of_its_table(
    path: str, table: dict[str, Any], other: str
) -> None:
    with pytest.raises(CaseError) as caught:
        parse_case(placed(path, {**table, "qqqq": 1}))
    (told,) = [each for each in str(caught.value).splitlines() if ".qqqq: unknown key" in each]
    assert told.startswith(f"case.toml: {path}.qqqq: ") and f"'{other}'" in told


def test_an_unknown_key_of_a_segment_is_told_with_its_keys() -> None:
    tables = pad()
    tables["loads"]["shear"]["history"] = [{"hold": True, "until": 1}, {**WAVE, "qqqq": 1}]
    with pytest.raises(CaseError, match=r"shear\.history\[segment 2\]\.qqqq: .*'steps_per_cycle'"):
        parse_case(tables)
