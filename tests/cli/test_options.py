# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of the command line."""

from __future__ import annotations

import pytest
from harness.launch import fretfe

POSITIVE = {
    "submodel": ("run", "--around", "main", "-o", "part", "--radius"),
    "submodel --size": ("run", "--around", "main", "-o", "part", "--size"),
    "submodel --length": ("run", "--around", "main", "--run", "--length"),
    "strength": ("tests.csv", "run", "--life"),
    "assess": ("run", "--material", "steel.toml", "--life"),
    "assess --at-least": ("run", "--material", "steel.toml", "--at-least"),
    "forces": ("run", "a.inp", "S", "--body", "b", "-o", "f", "--factor"),
}


@pytest.mark.parametrize("value", ["0", "nan", "inf", "-inf", "1e-320", "-2", "one"])
@pytest.mark.parametrize("command", POSITIVE)
def test_numbers_that_have_to_be_positive(command: str, value: str) -> None:
    done = fretfe(command.split()[0], *POSITIVE[command], value)
    assert done.returncode == 2
    assert f"found {value!r}" in " ".join(done.stderr.split()), done.stderr
    assert "Traceback" not in done.stderr


def test_a_positive_number_is_taken() -> None:
    # There is no such folder, which is looked at after the number.
    done = fretfe("strength", "tests.csv", "none", "--life", "1e6")
    assert "--life" not in done.stderr
