# SPDX-License-Identifier: LGPL-3.0-or-later
"""Result files of CalculiX: text and binary ones of CalculiX 2.20, and files that are wrong.

The model is free to expand: a C3D20, a C3D10 and a C3D15, each held at one corner, heated from 20
to 120 degrees until t = 1 and to 220 until t = 1.5, with an expansion of 1e-5.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from random import Random

import numpy as np
import pytest

from fretfe.errors import CaseError
from fretfe.fields import frd
from fretfe.fields.frd import Frd, read_frd

DATA = Path(__file__).parents[1] / "data"
TEXT, BINARY = DATA / "solids.frd", DATA / "solids_binary.frd"
# Nodes on edges by VTK's numbers of the shapes: the corners that each is in the middle of.
MIDDLES = {
    25: (
        *((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)),
        *((0, 4), (1, 5), (2, 6), (3, 7)),
    ),
    24: ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
    26: ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
}
CORNERS = {25: 8, 24: 4, 26: 6}


def with_text(folder: Path, change: Callable[[str], str]) -> Path:
    path = folder / "a.frd"
    path.write_text(change(TEXT.read_text()))
    return path


def short(text: str) -> str:
    """The same file with numbers of five digits."""
    text = re.sub(r"^ -([12]) {5}(?=[ \d]{5})", r" -\1", text, flags=re.MULTILINE)
    lines = []
    for line in text.splitlines():
        if re.match(r" +[23]C|  100CL", line):
            line = line[: len(line) - 1] + "0"
        elif line.startswith(" -2"):
            numbers = (line + " " * 2).removeprefix(" -2")
            line = " -2" + "".join(f"{int(each):5d}" for each in numbers.split())
        lines.append(line)
    return "\n".join(lines) + "\n"


def expected(found: Frd) -> np.ndarray:
    """Displacements per degree: each element grows from its first corner."""
    corners = np.array([[0, 0, 0], [4, 0, 0], [8, 0, 0]])
    owner = np.searchsorted([20, 30], found.numbers, side="left")
    owner = np.where(found.numbers > 40, 2, owner)
    return 1e-5 * (found.points - corners[owner])


@pytest.mark.parametrize("kind", ["text", "binary", "short", "Windows"])
def test_free_expansion(tmp_path: Path, kind: str) -> None:
    windows = with_text(tmp_path, lambda text: text.replace("\n", "\r\n"))
    if kind == "short":
        windows.unlink()
    path = {"text": TEXT, "binary": BINARY, "Windows": windows}.get(kind) or with_text(
        tmp_path, short
    )
    found = read_frd(path)
    np.testing.assert_array_equal(found.times, [1.0, 1.5])
    assert found.points.shape == (45, 3)
    assert found.numbers.tolist() == [*range(1, 31), *range(41, 56)]
    for step, change in enumerate((100.0, 200.0)):
        np.testing.assert_allclose(
            found.values(step), change * expected(found), rtol=1e-5, atol=1e-10
        )
    assert found.notes == (f"{path.name}: results that are not used: 2 ERROR, 2 NDTEMP, 2 STRESS",)
    heated = read_frd(path, "NDTEMP")
    np.testing.assert_array_equal(heated.times, [1.0, 1.5])
    for step, change in enumerate((100.0, 200.0)):
        np.testing.assert_array_equal(heated.values(step)[:, 0], 20.0 + change)


@pytest.mark.parametrize("path", [TEXT, BINARY])
def test_nodes_of_elements_are_in_the_order_of_vtk(path: Path) -> None:
    found = read_frd(path)
    assert found.shapes.tolist() == [25, 24, 26]
    assert found.offsets.tolist() == [0, 20, 30, 45]
    for shape, first, last in zip(found.shapes, found.offsets, found.offsets[1:], strict=False):
        points = found.points[found.nodes[first:last]]
        middles = [points[list(ends)].mean(axis=0) for ends in MIDDLES[int(shape)]]
        np.testing.assert_allclose(points[CORNERS[int(shape)] :], middles, atol=1e-15)


def test_plane_elements_of_order_1(tmp_path: Path) -> None:
    """A mesh of a quadrilateral and a triangle; some nodes have no displacements."""
    nodes = [(1, 0, 0), (2, 1, 0), (4, 1, 1), (3, 0, 1), (7, 2, 0)]
    text = f"    1C\n    2C{5:30d}{1:38d}\n"
    text += "".join(f" -1{n:10d}{x:12.5E}{y:12.5E}{0:12.5E}\n" for n, x, y in nodes) + " -3\n"
    text += f"    3C{2:30d}{1:38d}\n"
    text += f" -1{1:10d}{9:5d}{0:5d}{1:5d}\n -2" + "".join(f"{n:10d}" for n in (1, 2, 4, 3)) + "\n"
    text += (
        f" -1{2:10d}{7:5d}{0:5d}{1:5d}\n -2" + "".join(f"{n:10d}" for n in (2, 7, 4)) + "\n -3\n"
    )
    text += f"  100CL  101{0.25:12.9f}{1:12d}{'':20}{0:2d}{1:5d}{'':10}{1:2d}\n"
    text += f" -4  DISP    {4:5d}{1:5d}\n"
    for name, computed in (("D1", 0), ("D2", 0), ("D3", 0), ("ALL", 1)):
        text += f" -5  {name:8}{1:5d}{2:5d}{1:5d}{0:5d}{computed:5d}\n"
    # exponents of three digits run over their columns
    text += f" -1{7:10d}{-1e-120:12.5E}{2e-3:12.5E}{0:12.5E}\n -3\n 9999\n"
    (tmp_path / "a.frd").write_text(text)
    found = read_frd(tmp_path / "a.frd")
    assert found.numbers.tolist() == [1, 2, 3, 4, 7]
    assert found.shapes.tolist() == [9, 5]
    assert found.nodes.tolist() == [0, 1, 3, 2, 1, 4, 3]
    values = found.values(0)
    np.testing.assert_array_equal(values[4], [-1e-120, 2e-3, 0.0])
    assert np.isnan(values[:4]).all()
    with pytest.raises(CaseError, match=r"expected results NDTEMP of a static or transient run"):
        read_frd(tmp_path / "a.frd", "NDTEMP")


def windows(text: str) -> str:
    """The same file with exponents of three digits: numbers stand without a blank."""
    return re.sub(r"( ?)(-?\d\.\d{5}E[-+])(\d\d)", r"\g<2>0\3", text)


def test_exponents_of_three_digits(tmp_path: Path) -> None:
    """As some builds for Windows write them, so that rows differ in length."""
    path = with_text(tmp_path, windows)
    text = path.read_text()
    lengths = {len(line) for line in text.splitlines() if re.match(r" -1.*E[-+]\d{3}$", line)}
    assert len(lengths) > 1 and re.search(r"E-\d{3}\d\.", text)
    expected, found = read_frd(TEXT), read_frd(path)
    np.testing.assert_array_equal(found.points, expected.points)
    for step in (0, 1):
        np.testing.assert_array_equal(found.values(step), expected.values(step))
    # -3e-4, -4e-3 and 0 without blanks, and a number more than there are components
    row = "-3.00000E-004-4.00000E-0030.00000E+000"
    first = re.search(r"(?m)^( -1 +1)[-\d].*E[-+]\d{3}$", text.partition(" -5  ALL")[2])
    assert first
    changed = text.replace(first[0], first[1] + row)
    path.write_text(changed)
    assert read_frd(path).values(0)[0].tolist() == [-3e-4, -4e-3, 0.0]
    path.write_text(changed.replace(row, f"{row}1.00000E+000"))
    assert "cannot read its numbers: expected 3 of them" in refused(path)


def refused(path: Path) -> str:
    with pytest.raises(CaseError) as caught:
        found = read_frd(path)
        for step in range(len(found.times)):
            found.values(step)
    assert str(path) in str(caught.value)
    return str(caught.value)


DISP = re.compile(r"(?s).*? -5  ALL.*?\n")


def in_values(old: str, new: str) -> Callable[[str], str]:
    """Replace something in the first displacements."""

    def change(text: str) -> str:
        match = DISP.match(text)
        assert match and old in text[match.end() :]
        return text[: match.end()] + text[match.end() :].replace(old, new, 1)

    return change


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda text: "", "cannot read the result file"),
        (lambda text: "solid\n" * 9, "expected a result file of CalculiX, which begins with 1C"),
        (lambda text: text.replace(" 9999\n", ""), "the file is not whole"),
        (lambda text: text[:20_000], "expected -3 at the end of rows, found none"),
        (lambda text: text[:1000], "expected -3 at the end of rows, found none"),
        (
            in_values("1.00000E-03", "        NaN"),
            "DISP: expected finite numbers, found nan at node",
        ),
        (
            in_values("1.00000E-03", "        INF"),
            "DISP: expected finite numbers, found inf at node",
        ),
        (in_values("1.00000E-03", "1.0zzzzE-03"), "DISP: cannot read its numbers"),
        (
            in_values(" -1         2", " -1        99"),
            "values of node 99, which is not in the mesh",
        ),
        (in_values(" -1         2", " -1         1"), "two values of node 1"),
        (in_values(" -1         2", " -1999999999999"), "DISP: "),
        (
            lambda text: re.sub(r" -1 {9}2.*\n", "", text, count=1),
            "expected 45 rows of values, found",
        ),
        (lambda text: text.replace("    45  ", "    46  ", 1), "nodes: expected 46 rows"),
        (
            lambda text: text.replace("          45  ", "999999999999  "),
            "expected at most 50,000,000 nodes",
        ),
        (
            lambda text: text.replace("          45  ", "         -45  "),
            "a number of nodes, found '-45'",
        ),
        (lambda text: text.replace("DISP  ", "SPEED "), "at times that increase, found none"),
        (
            lambda text: text.replace("1.500000000", "0.500000000"),
            "at times that increase, found 1, 0",
        ),
        (
            lambda text: text.replace("1.500000000", "nan        "),
            "at times that increase, found 1, nan",
        ),
        (lambda text: text.replace("1.500000000", "now        "), "expected a time, found 'now'"),
        (
            lambda text: text.replace(" -1         7    6", " -1         7   66"),
            "kinds 1 to 12, found 66",
        ),
        (
            lambda text: text.replace("        29        30", "        29        77"),
            "element of node 77",
        ),
        (
            lambda text: text.replace("         3    ", "         4    ", 1),
            "expected 4 elements, found 3",
        ),
        (
            lambda text: text.replace("   1\n -1 ", "   9\n -1 ", 1),
            "expected a form from 0 to 3, found 9",
        ),
        (lambda text: text.replace(" -1         3", " -1         2", 1), "found node 2 twice"),
        (lambda text: "    1C\n 9999\n", "expected nodes, found none"),
        (lambda text: text + "x", ""),
    ],
)
def test_files_that_are_wrong(tmp_path: Path, change: Callable[[str], str], message: str) -> None:
    path = with_text(tmp_path, change)
    if message:
        found = refused(path)
        assert message in found, found
    else:  # nothing is read behind the last record
        assert len(read_frd(path).times) == 2


def test_binary_files_that_are_wrong(tmp_path: Path) -> None:
    path, data = tmp_path / "a.frd", BINARY.read_bytes()
    for last in (300, 1200, 2500, 3500, len(data) - 300):
        path.write_bytes(data[:last])
        refused(path)
    for count in (b"999999999999", b"          44", b"          46"):
        path.write_bytes(data.replace(b"          45", count))
        refused(path)


@pytest.mark.parametrize("source", [TEXT, BINARY])
def test_damaged_files(tmp_path: Path, source: Path) -> None:
    """Whatever happens to a file, it is read or refused in words."""
    random, path, data = Random(3), tmp_path / "a.frd", source.read_bytes()
    for _ in range(150):
        changed = bytearray(data)
        for _ in range(random.randint(1, 6)):
            changed[random.randrange(len(data))] = random.choice(b"0123456789 -+.CE\n\0\xff")
        path.write_bytes(changed[: random.choice((len(data), random.randrange(len(data))))])
        try:
            found = read_frd(path)
            assert np.isfinite(found.points).all()
            for step in range(len(found.times)):
                found.values(step)
        except CaseError as error:
            assert str(error).startswith(f"{path}: ")


def test_no_files(tmp_path: Path) -> None:
    assert "expected a result file of CalculiX" in refused(tmp_path)
    assert "found nothing at" in refused(tmp_path / "none.frd")


def test_elements_of_one_kind_are_read_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same as one by one, elements of two lines of nodes too."""
    for size, kind in ((4, 3), (10, 6), (20, 4)):
        text = f"    1C\n    2C{30:30d}{1:38d}\n"
        text += "".join(f" -1{n:10d}{n:12.5E}{n % 7:12.5E}{n % 5:12.5E}\n" for n in range(1, 31))
        text += f" -3\n    3C{8:30d}{1:38d}\n"
        for element in range(1, 9):
            nodes = [f"{element + k:10d}" for k in range(size)]
            text += f" -1{element:10d}{kind:5d}{0:5d}{1:5d}\n"
            text += "".join(f" -2{''.join(nodes[k : k + 10])}\n" for k in range(0, size, 10))
        text += f" -3\n  100CL  101{1:12.9f}{30:12d}{'':20}{0:2d}{1:5d}{'':10}{1:2d}\n"
        text += f" -4  NDTEMP  {1:5d}{1:5d}\n -5  {'T':8}{1:5d}{1:5d}{0:5d}{0:5d}\n"
        text += "".join(f" -1{n:10d}{n:12.5E}\n" for n in range(1, 31)) + " -3\n 9999\n"
        path = tmp_path / "a.frd"
        path.write_text(text)
        fast = read_frd(path, "NDTEMP")
        with monkeypatch.context() as patch:
            patch.setattr(frd._Reader, "_elements_of_one_kind", lambda *_: None)
            slow = read_frd(path, "NDTEMP")
        assert len(fast.shapes) == 8
        for name in ("nodes", "offsets", "shapes"):
            np.testing.assert_array_equal(getattr(fast, name), getattr(slow, name))
        path.write_text(text.replace(f" -1{3:10d}{kind:5d}", f" -1{3:10d}{kind:4d}x"))
        assert "expected an element, found" in refused(path)
