# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of the command line."""

from __future__ import annotations

import pytest
import typer
from harness.launch import fretfe

from fretfe.cli.options import count, decimal, positive

POSITIVE = {
    "submodel": ("run", "--around", "main", "-o", "part", "--radius"),
    "submodel --size": ("run", "--around", "main", "-o", "part", "--size"),
    "submodel --length": ("run", "--around", "main", "--run", "--length"),
    "strength": ("tests.csv", "run", "--life"),
    "assess": ("run", "--material", "steel.toml", "--life"),
    "assess --at-least": ("run", "--material", "steel.toml", "--at-least"),
    "forces": ("run", "a.inp", "S", "--body", "b", "-o", "f", "--factor"),
}


@pytest.mark.parametrize("value", ["0", "nan", "inf", "1_0", "1e-320", "-2", "one"])
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


# Python reads all of them.
MISREAD = ["1_0", "nan", "infinity", "-inf", "1e999", " 2", "٣", ""]
NUMBERS = {
    "edges --friction": ("t.csv", "--friction"),
    "export --depth": ("run", "-o", "f", "--depth"),
    "export --angle": ("run", "-o", "f", "--angle"),
    "export --fatemi-socie": ("run", "-o", "f", "--fatemi-socie", "1"),
    "forces --time": ("run", "a.inp", "S", "--body", "b", "-o", "f", "--time"),
    "sweep --vary": ("c.toml", "-o", "f", "--backend", "halfplane", "--vary"),
}


@pytest.mark.parametrize("text", MISREAD)
def test_a_number_is_digits(text: str) -> None:
    expected = "expected a number like 3, -0.5 or 1e-3, found "
    with pytest.raises(typer.BadParameter) as caught:
        decimal(text)
    assert str(caught.value) == f"{expected}{text!r}"
    with pytest.raises(typer.BadParameter):
        count(text)


@pytest.mark.parametrize(
    ("text", "value"), [("3", 3.0), ("-0.5", -0.5), ("+.5", 0.5), ("2.", 2.0), ("1E-3", 1e-3)]
)
def test_numbers_as_people_write_them(text: str, value: float) -> None:
    assert decimal(text) == value
    assert positive(text.lstrip("-")) == abs(value)


@pytest.mark.parametrize("text", ["0", "-1", "1.5", "2e3", "²"])
def test_counts_are_whole(text: str) -> None:
    with pytest.raises(typer.BadParameter) as caught:
        count(text)
    assert str(caught.value) == f"expected a whole number of 1 or more, found {text!r}"
    assert count("12") == 12


@pytest.mark.parametrize("command", NUMBERS)
def test_every_option_with_a_number_takes_digits_alone(command: str) -> None:
    name = command.split()[0]
    value = "loads.q.amplitude=1_0:2:3" if name == "sweep" else "1_0"
    done = fretfe(name, *NUMBERS[command], value)
    said = " ".join(done.stderr.split())
    assert done.returncode == 2 and "1_0" in said and "expected" in said, said
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("words", [("run", "c.toml", "-o", "f"), ("check", "c.toml")])
def test_ranks_are_a_count(words: tuple[str, ...]) -> None:
    done = fretfe(*words, "--ranks", "1_0")
    assert done.returncode == 2
    assert "expected a whole number of 1 or more, found '1_0'" in " ".join(done.stderr.split())
