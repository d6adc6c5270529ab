# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files of tests with loads: what is read, converted, left out and refused."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from cases.pad_cases import cylinder, pad_text
from cases.stored_runs import solved
from harness.launch import fretfe as command

import fretfe
from fretfe.case import Units
from fretfe.errors import CaseError
from fretfe.strength.lives import StrengthTests, read_tests

DOCS = Path(__file__).parents[2] / "docs" / "strength.md"
HEADER = "P [N/mm],Q [N/mm],bulk [MPa],radius [mm],f,E [MPa],nu,life,runout"
# Of the pad of `pad_text`.
SURVIVES = (
    r"pad is expected to survive 180000 cycles, because .* margin (\S+), of 95 % of parts "
    r"(\S+) to \S+\n"
)
ROW = "400,40,0,50,0.4,210e3,0.3,4e5,0"


def read(folder: Path, text: str) -> StrengthTests:
    path = folder / "tests.csv"
    path.write_text(text, "utf-8")
    return read_tests(path, Units())


def test_the_table_of_the_docs(tmp_path: Path) -> None:
    page = DOCS.read_text("utf-8")
    (table,) = re.findall(r"```\n(P \[N\].*?)```", page, re.DOTALL)
    found = read(tmp_path, table)
    said = re.search(r"K_N = ([\d ]+) MPa/√mm and ΔK_T = ([\d.]+), ([\d.]+) and ([\d.]+) ", page)
    assert said is not None
    k_n, *ranges = (float(each.replace(" ", "")) for each in said.groups())
    np.testing.assert_allclose(found.k_n, k_n, rtol=5e-4)
    np.testing.assert_allclose(found.k_t_range, ranges, rtol=2e-3)
    assert found.runout.tolist() == [False, True, False] and found.life[1] == 1e7
    assert [bool(each) for each in found.outside] == [False, False, True]
    assert f"d is {found.outside[2].split('d is ')[1].split(' of')[0]} a" in page


SAME = {
    "units": (
        "P [kN/m],Q [kN/mm],bulk [GPa],radius [m],f,E [GPa],nu,life,runout",
        "400,0.04,0.02,0.05,0.4,210,0.3,4e5,0",
    ),
    "forces": (
        "P [kN],Q [N],bulk [N/mm^2],radius [cm],thickness [mm],mu,young [GPa],poisson,life,runout",
        "4,400,20,5,10,0.4,210,0.3,4e5,0",
    ),
    "semicolons": (
        HEADER.replace(",", ";"),
        "400,0;40;20;50;0,4;210e3;0,3;4e5;0",
    ),
    "marks": (HEADER.removesuffix(",runout"), "400,40,20,50,0.4,210e3,0.3,4e5\n" + ROW[:-5] + ">9"),
    "order": (
        "test,life,E [MPa],nu,f,radius [mm],bulk [MPa],Q [N/mm],P [N/mm],runout",
        "1,4e5,210e3,0.3,0.4,50,20,40,400,0",
    ),
    "material": (
        HEADER.replace("E [MPa],nu", "material"),
        "400,40,20,50,0.4,own.toml,4e5,0",
    ),
    "case": (
        "P [N/mm],Q [N/mm],bulk [MPa],case,f,life,runout",
        "400,40,20,pad.toml,0.4,4e5,0",
    ),
}


@pytest.mark.parametrize("name", SAME)
def test_the_same_test_in_other_words(tmp_path: Path, name: str) -> None:
    own = 'source = "here"\nyoung = 210.0\npoisson = 0.3\nunits = {stress = "GPa"}\n'
    (tmp_path / "own.toml").write_text(own)
    # Of a block that is longer than high the held end carries Q.
    long = cylinder(lower_width=24.0, lower_height=12.0)
    (tmp_path / "pad.toml").write_text(pad_text(geometry=long))
    header = "P [N/mm],Q [N/mm],bulk [MPa],radius [mm],f,E [MPa],nu,life,runout"
    plain = header, "400,40,20,50,0.4,210e3,0.3,4e5,0"
    if name == "case":
        plain = f"{header},height [mm]", f"{plain[1]},12"
    expected, found = (read(tmp_path, "\n".join(each)) for each in (plain, SAME[name]))
    for column in ("k_n", "k_t_range", "life", "friction", "young", "poisson", "runout"):
        value = getattr(found, column)[0]
        assert value == pytest.approx(getattr(expected, column)[0], rel=1e-12), column


# What stands in place of what in the header or in the row, and the message.
REFUSED = {
    "unit": ("P [N/mm]", "P [MPa]", r"line 1, column 'p': expected a unit as \[N/mm\], found \[M"),
    "force": ("Q [N/mm]", "Q [kN]", "column 'q': .* needs a column 'thickness'"),
    "no unit": ("bulk [MPa]", "bulk", "column 'bulk': .* found none"),
    "no bulk": ("bulk [MPa]", "sigma", r"expected a column 'bulk' \(0 will do\), found 'p', "),
    "no radius": ("radius [mm]", "size", "expected a column 'radius', found"),
    "no modulus": ("E [MPa]", "modulus", "expected a column 'young', found"),
    "twice": ("nu", "mu", "expected one column 'friction', found two"),
    "two materials": ("nu", "material", "either a column 'material' or 'young', found both"),
    "no run-outs": ("runout", "ended", "expected a column 'runout', or marks as in >1e7"),
    "decimal commas": ("0.4", "0,4", "line 2: expected at most 9 cells, .* decimal comma"),
    "text": ("40,0,", "forty,0,", r"line 2, column 'Q \[N/mm\]': .* found 'forty'"),
    "life": ("4e5", "-4e5", "line 2, column 'life': expected a number > 0, found -4"),
    "P": ("400,", "-400,", r"line 2, column 'P \[N/mm\]': expected a number > 0, found -400"),
    "Q": (",40,", ",-40,", "an amplitude >= 0, found -40"),
    "still": (",40,", ",0,", r"'Q \[N/mm\]': expected a number > 0, or a bulk stress, found 0"),
    "GPa": ("210e3", "210", "line 2, column 'P .*check units"),
    "Pa": ("400,", "0.0004,", "line 2, column 'P .*check units"),
    "steal": ("E [MPa],nu 210e3,0.3", "material steal", "2, column 'material': .*mean 'steel'"),
    "crystal": ("E [MPa],nu 210e3,0.3", "material nickel-crystal", "material with young and pois"),
    "case": ("radius [mm] 50,", "case none.toml,", "line 1: expected either a column 'case' or"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_mistakes(tmp_path: Path, name: str) -> None:
    old, new, message = REFUSED[name]
    text = f"{HEADER}\n{ROW}\n"
    header, _, row = old.rpartition(" ")
    if not header or (old.endswith("]") and "[" in old):
        changed = text.replace(old, new)
    else:
        first, _, second = new.rpartition(" ")
        changed = text.replace(header, first).replace(row, second)
    assert changed != text
    with pytest.raises(CaseError, match=message) as caught:
        read(tmp_path, changed)
    assert str(tmp_path / "tests.csv") in str(caught.value)


def loaded_tests() -> str:
    """Cylinders whose lives follow log10 N = 11.8 - 4 log10 ΔK_T, nearly."""
    random = np.random.default_rng(5)
    rows = [HEADER]
    for share in np.linspace(0.1, 0.33, 16):
        force, radius = random.uniform(400, 800), random.choice([40, 50, 60])
        a = np.sqrt(4 * force * radius / (np.pi * 210e3 / (2 * 0.91)))
        shear = 0.4 * share * force
        size = 2 * shear / (np.pi * np.sqrt(2 * a))
        life = 10 ** (11.8 - 4 * np.log10(size) + 0.1 * random.standard_normal())
        rows.append(f"{force},{shear},0,{radius},0.4,210e3,0.3,{min(life, 2e6)},{int(life > 2e6)}")
    return "\n".join(rows)


def test_what_is_left_out_does_not_count(tmp_path: Path) -> None:
    path = tmp_path / "tests.csv"
    path.write_text(loaded_tests())
    one = fretfe.strength_map(path, [solved("halfplane")], 2e5)
    path.write_text(f"{loaded_tests()}\n400,161,0,50,0.4,210e3,0.3,1e3,0\n")
    two = fretfe.strength_map(path, [solved("halfplane")], 2e5)
    assert two.margins[0].margin == one.margins[0].margin and two.margins[0].tests == 16
    # ΔK_T of the pad, and the life that it would have by the law of the tests.
    strength = 10 ** ((11.8 - np.log10(2e5)) / 4)
    assert one.margins[0].strength == pytest.approx(strength, rel=0.1)
    path.write_text(f"{HEADER}\n400,161,0,50,0.4,210e3,0.3,1e3,0\n")
    none = fretfe.strength_map(path, [solved("halfplane")], 2e5).margins[0]
    assert none.reason.startswith("all tests with its friction and material lie outside")


@pytest.mark.pictures
def test_command_ends_with_what_to_expect(tmp_path: Path) -> None:
    tests, case = tmp_path / "tests.csv", tmp_path / "pad.toml"
    tests.write_text(f"{loaded_tests()}\n400,161,0,50,0.4,210e3,0.3,1e3,0\n")
    case.write_text(pad_text(title="pad"))
    done = command("strength", tests, case, "--life", "1.8e5", "-o", tmp_path / "map")
    assert done.returncode == 0, done.stderr
    assert "line 18 of tests.csv is left out: the contact slides as a whole" in done.stdout
    found = re.search(SURVIVES, done.stdout)
    assert found and float(found[1]) > float(found[2]) > 1
    done = command("strength", tests, case, "--life", "1.2e6")
    assert "pad is expected to fail within 1.2e6 cycles, because " in done.stdout
