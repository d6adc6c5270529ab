# SPDX-License-Identifier: LGPL-3.0-or-later
"""The report is one file that loads nothing, takes no markup from users, says what was found."""

from __future__ import annotations

import base64
import json
import math
import re
import subprocess
import sys
from dataclasses import dataclass, field, replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from cases.pad_cases import STEEL, pad
from cases.stored_runs import REASON, RUNS, edit_numbers, solved, write_many_contacts, write_run
from harness.plots import whole_plots

from fretfe.case import parse_case
from fretfe.errors import OutputError
from fretfe.evaluate.refinement import Pass, Refinement, StationValues, edge_changes
from fretfe.materials.moduli import contact_modulus
from fretfe.report.page.glossary import HEADERS, PLANE_TERMS, SOLID_TERMS, TERMS, Glossary
from fretfe.report.page.html import render, write_report
from fretfe.report.page.tables import station_table
from fretfe.results.reader import read_result
from fretfe.results.writer import REPORT, write_results

SCRIPT = "<script>alert(1)</script>"
# A name of the SVG and XLink languages is no address that is loaded.
NAMESPACE = re.compile(r'xmlns(:\w+)?="[^"]*"')
PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNgAAAAAgABSK+kcQAAAABJRU5ErkJggg=="
)


@dataclass
class Page(HTMLParser):
    """What is in a page: tags, ids, references, and the text of its cells and headings."""

    text: str
    tags: list[str] = field(default_factory=list)
    ids: list[str] = field(default_factory=list)
    references: list[str] = field(default_factory=list)
    words: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()
        self.feed(self.text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        for name, value in attrs:
            assert not name.startswith("on"), (tag, name)
            if name == "id":
                self.ids.append(value or "")
            if name in ("src", "href", "xlink:href", "srcset", "data", "action", "poster"):
                self.references.append(value or "")
            self.references += re.findall(r"url\(([^)]*)\)", value or "")

    def handle_data(self, data: str) -> None:
        self.words.append(data.strip())

    def rows(self, heading: str) -> list[list[str]]:
        """Cells of the table below a heading; spans fill the rows that they reach."""
        table = self.text.split(f"<h3>{heading}")[-1].split("<tbody>")[1].split("</tbody>")[0]
        rows: list[list[str]] = []
        above: list[str] = []
        for row in re.split("<tr[^>]*>", table)[1:]:
            cells = [re.sub("<[^>]*>", "", cell) for cell in re.findall("<t[dh].*?</t[dh]>", row)]
            cells = above[: len(above) - len(cells)] + cells if above else cells
            rows.append(cells)
            above = cells
        return rows


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The report of each run."""
    folder = tmp_path_factory.mktemp("runs")
    with whole_plots():
        return {name: render(write_run(folder / name, name)) for name in RUNS}


def check_alone(text: str) -> Page:
    """Nothing is loaded from anywhere, nothing runs, all ids are there once."""
    page = Page(text)
    assert not {"script", "iframe", "object", "embed"} & set(page.tags)
    assert "@import" not in text and "http" not in NAMESPACE.sub("", text)
    assert len(page.ids) == len(set(page.ids))
    anchors = {f"#{name}" for name in page.ids}
    assert all(each.startswith("data:") or each in anchors for each in page.references)
    return page


@pytest.mark.parametrize("name", RUNS)
def test_page_is_one_file_that_loads_nothing(pages: dict[str, str], name: str) -> None:
    page = check_alone(pages[name])
    assert len(pages[name]) < 1.5e6
    # Tractions, 2 edges, slip map, factors, loads, path, loops.
    assert page.tags.count("svg") >= 8
    assert page.tags.count("table") >= 5
    assert ("Not all load steps were solved" in pages[name]) == (name == "incomplete")


@pytest.mark.parametrize(
    ("upper", "row", "beta"),
    [
        (
            {
                "elastic": {"cubic": [252e3, 161e3, 131e3]},
                "orientation": {"z": [0, 0, 1], "x": [2, 1, 0]},
            },
            [
                *("cubic crystal", "c11 = 2.52e5, c12 = 1.61e5, c44 = 1.31e5"),
                *("[1 0.5 0]", "[-0.5 1 0]", "[0 0 1]"),
            ],
            "±",
        ),
        (
            {"young": 114e3, "poisson": 0.34},
            ["isotropic", "E = 1.14e5, ν = 0.34"],
            "-0.0531",
        ),
    ],
    ids=["crystal", "titanium"],
)
def test_bodies_and_pairs(tmp_path: Path, upper: dict[str, Any], row: list[str], beta: str) -> None:
    tables = pad(bodies={"upper": upper, "lower": STEEL})
    write_run(tmp_path, "halfplane", parse_case(tables))
    page = Page(render(tmp_path, ()))
    first, second = page.rows("Bodies")
    assert first == ["upper", *row]
    # Axes are those of crystals.
    assert second == ["lower", "isotropic", "E = 2.1e5, ν = 0.3", *["-"] * (len(row) - 2)]
    ((*names, modulus, found),) = page.rows("Pairs")
    assert names == ["main", "upper on lower", "0.4"]
    assert found.startswith(beta)
    pair = parse_case(tables).bodies
    expected = contact_modulus(pair["upper"], pair["lower"], "strain", np.array([0.0, 1.0]))
    assert float(modulus) == pytest.approx(expected, rel=1e-3)


def test_terms_of_the_tables_are_explained_below(pages: dict[str, str]) -> None:
    text = pages["halfplane"]
    head, terms = text.split('<h2 id="terms">')
    links = re.findall(r'class="term" href="#([\w-]+)" title="[^"]{20,}"', head)
    assert {"term-k_n", "term-k_t", "term-slip-zone", "term-verdict"} <= set(links)
    assert all(f'<dt id="{link}">' in terms for link in links)
    assert terms.count("<dd>") == len(TERMS | PLANE_TERMS)
    # What is left of the links of the documents would lead nowhere.
    assert not re.search(r"\.md|\]\(|[*`]", terms)


def test_terms_are_those_of_the_glossary() -> None:
    plane, solid = ({term.name for term in Glossary(solid).terms} for solid in (False, True))
    assert (plane, solid) == (TERMS | PLANE_TERMS, TERMS | SOLID_TERMS)
    assert set(HEADERS.values()) <= plane | solid


def test_answer_comes_first_with_numbers_and_verdicts(pages: dict[str, str]) -> None:
    (contact,) = solved("halfplane").contacts
    text = pages["halfplane"]
    assert text.index('id="answer"') < text.index("<svg")
    rows = Page(text).rows("Contact edges")
    assert [row[:2] for row in rows] == [["main", side] for side in ("left",) * 2 + ("right",) * 2]
    zones = [(edge, zone) for edge in contact.stations for zone in edge.slip_zones[-2:]]
    for row, (edge, zone) in zip(rows, zones, strict=True):
        # All digits but the last ones.
        assert float(row[3].split("±")[0]) == pytest.approx(edge.k_n[-1], rel=1e-3)
        assert float(row[4].split("±")[0]) == pytest.approx(edge.k_t_range, rel=1e-3)
        assert float(row[6].split("±")[0]) == pytest.approx(zone.length, rel=1e-2)
        assert float(row[7]) == pytest.approx(zone.prediction, rel=1e-2)
        assert float(row[8]) == pytest.approx(zone.prediction / zone.length, rel=1e-2)
        assert row[9] == "agrees"
    assert "At 2 of 2 edges the longest slip zone agrees with the prediction" in text


def test_without_a_cycle_first_loading_is_compared(pages: dict[str, str]) -> None:
    rows = Page(pages["no cycle"]).rows("Contact edges")
    assert [(row[4], row[9]) for row in rows] == [("-", "agrees")] * 2
    assert "There is no evaluated cycle" in pages["no cycle"]


# Changes of the last slip zone in results.json, and the verdict.
VERDICTS = {
    "agrees": {},
    "differs": {"predicted": 0.04, "predicted_loop": None},
    "gross": {"length": None, "gross": True},
    "not resolved": {"resolved": False},
    "no verdict": {"predicted": None, "predicted_loop": None},
}


@pytest.mark.parametrize("verdict", VERDICTS)
def test_verdicts(tmp_path: Path, verdict: str) -> None:
    folder = write_run(tmp_path, "halfplane")
    edit_numbers(
        folder,
        lambda n: n["contacts"]["main"]["fronts"][1]["stations"][0]["slip_zones"][-1].update(
            VERDICTS[verdict]
        ),
    )
    rows = Page(render(folder)).rows("Contact edges")
    assert [row[9] for row in rows] == ["agrees"] * 3 + [verdict]


@pytest.mark.parametrize(
    ("zone", "found", "printed"),
    [
        ({"spread": 0.09}, "1.000 ± 0.090", "1"),
        ({"spread": 0.11}, "~1.00 ± 0.11", "~1"),
        ({"spread": 0.01, "resolved": False}, "~1.000 ± 0.010", "~1"),
        ({"spread": 0.6}, "-", "-"),
        ({"length": 0.0, "spread": 0.02}, "&lt; 0.02", "< 0.02"),
        ({"length": 0.0, "spread": 0.02, "resolved": False}, "&lt; 0.02", "< 0.02"),
    ],
)
def test_vague_zones_are_marked_and_no_slip_is_0(
    tmp_path: Path, zone: dict[str, object], found: str, printed: str
) -> None:
    folder = write_run(tmp_path, "halfplane")
    change = {"length": 1.0, "resolved": True, **zone}
    edit_numbers(
        folder,
        lambda n: n["contacts"]["main"]["fronts"][1]["stations"][0]["slip_zones"][-1].update(
            change
        ),
    )
    assert Page(render(folder)).rows("Contact edges")[-1][6] == found
    run = read_result(folder)
    table = station_table(run)
    assert table is not None
    cells = list(table.columns[-2].cells)
    assert str(cells[-1]).endswith(f" / {printed}")


def test_large_expected_error_excuses_nothing(tmp_path: Path) -> None:
    """A formula that expects an error of 40 % does not agree with a length that is 40 % off."""
    folder = write_run(tmp_path, "halfplane")

    def edit(numbers: dict) -> None:
        edge = numbers["contacts"]["main"]["fronts"][0]["stations"][0]
        zone = edge["slip_zones"][-1]
        edge["stiffening"] = 0.8 / zone["length"]
        zone.update(predicted=0.6 * zone["length"], predicted_loop=None)

    edit_numbers(folder, edit)
    assert Page(render(folder)).rows("Contact edges")[1][9] == "outside"


def test_what_a_user_wrote_is_text(tmp_path: Path) -> None:
    case = parse_case(
        pad(
            title=SCRIPT,
            units={"length": f"m{SCRIPT}$x_1$", "stress": "&<b>'\"", "time": "{{ 1 }}"},
        )
    )
    with whole_plots():
        page = check_alone(render(write_run(tmp_path, "no cycle", case)))
    assert "b" not in page.tags
    assert page.words.count(SCRIPT) >= 2  # heading and case
    assert any("{{ 1 }}" in words for words in page.words)


def test_failure_is_told_as_text(pages: dict[str, str]) -> None:
    page = Page(pages["incomplete"])
    assert any(REASON in words for words in page.words)
    assert "All 11 load steps are solved" not in pages["incomplete"]


def test_many_contacts(tmp_path: Path) -> None:
    with whole_plots():
        text = render(write_many_contacts(tmp_path, 2))
    page = check_alone(text)
    assert len(page.rows("Contact edges")) == 2 * 2 * 2
    # For each contact: tractions, edges, slip map, local parameters, factors, path, loop; for all:
    # loads, one boundary that works.
    assert page.tags.count("svg") == 2 * 8 + 2
    assert len(text) < 4e6


def test_notes_and_warnings_are_shown(tmp_path: Path) -> None:
    folder = write_run(tmp_path, "halfplane")
    subject = {"contact": "main", "front": ""}
    gap = {"kind": "fault", "subject": subject, "text": "mind <the> gap", "partly": False}
    edit_numbers(folder, lambda n: n["contacts"]["main"]["warnings"].append(gap))
    page = Page(render(folder))
    assert any("mind <the> gap" in words for words in page.words)
    assert any("the platen does not turn" in words for words in page.words)


def write_pictures(folder: Path, listed: object) -> None:
    (folder / "pictures").mkdir()
    (folder / "pictures" / "a.png").write_bytes(PIXEL)
    (folder / "pictures" / "pictures.json").write_text(json.dumps(listed), "utf-8")


PICTURE = {"file": "a.png", "title": "T <i>", "caption": "C & c", "width": 1, "height": 1}
MISSING = {"title": "Stress", "reason": "pip install 'fretfe[report]'"}


def test_pictures_are_in_the_page_and_missing_ones_are_named(tmp_path: Path) -> None:
    folder = write_run(tmp_path, "halfplane")
    assert "Pictures" not in render(folder)
    write_pictures(
        folder, {"pictures": [PICTURE, PICTURE], "missing": [MISSING, {**MISSING, "title": "More"}]}
    )
    page = check_alone(render(folder))
    assert page.tags.count("img") == 2
    (source,) = {each for each in page.references if each.startswith("data:image")}
    assert base64.b64decode(source.split(",")[1]) == PIXEL
    assert "T <i>" in page.words and "C & c" in page.words
    assert any("Stress; More" in words and MISSING["reason"] in words for words in page.words)


@pytest.mark.parametrize(
    "listed",
    [
        [],
        {"pictures": [], "missing": [1]},
        {"pictures": [{**PICTURE, "file": "b.png"}], "missing": []},
        {"pictures": [{"file": "a.png"}], "missing": []},
    ],
    ids=["a list", "no table", "no such picture", "no title"],
)
def test_bad_list_of_pictures_gets_a_clear_message(tmp_path: Path, listed: object) -> None:
    folder = write_run(tmp_path, "halfplane")
    write_pictures(folder, listed)
    with pytest.raises(OutputError, match="pictures"):
        render(folder)


def test_picture_outside_the_folder_is_not_read(tmp_path: Path) -> None:
    folder = write_run(tmp_path, "halfplane")
    (tmp_path / "secret").write_bytes(b"secret")
    write_pictures(folder, {"pictures": [{**PICTURE, "file": "../secret"}], "missing": []})
    with pytest.raises(OutputError, match="pictures"):
        render(folder)


def test_page_that_cannot_be_written(tmp_path: Path) -> None:
    folder = write_run(tmp_path, "halfplane")
    (folder / REPORT).mkdir()
    with pytest.raises(OutputError, match=r"report\.html"):
        write_report(folder)


def test_history_that_ended_before_its_first_step(tmp_path: Path) -> None:
    """Nothing but the unloaded state: no plot, no check, no crash."""
    folder = write_run(tmp_path, "halfplane")

    def cut(value: object, states: int) -> object:
        if isinstance(value, dict):
            return {key: cut(each, states) for key, each in value.items()}
        if isinstance(value, list) and len(value) == states:
            return [cut(each, states) for each in value[:1]]
        return [cut(each, states) for each in value] if isinstance(value, list) else value

    def edit(numbers: dict) -> None:
        whole = cut({**numbers, "case": None}, len(numbers["times"]))
        assert isinstance(whole, dict)
        numbers.update({**whole, "case": numbers["case"], "cycle": None, "complete": False})
        for front in numbers["contacts"]["main"]["fronts"]:
            (edge,) = front["stations"]
            edge.update(slip_zones=[], last=0, decisive=0)

    count = len(solved("halfplane").loads.times)
    edit_numbers(folder, edit)
    with h5py.File(folder / "results.h5", "r+") as arrays:
        names: list[str] = []
        arrays.visit(names.append)
        for name in names:
            if isinstance(arrays[name], h5py.Dataset) and arrays[name].shape[:1] == (count,):
                first = arrays[name][:1]
                del arrays[name]
                arrays[name] = first
    page = check_alone(render(folder))
    assert "svg" not in page.tags
    assert [row[-1] for row in page.rows("Contact edges")] == ["unknown"] * 2


WITHOUT = """
import sys
blocked = {"basix", "dolfinx", "gmsh", "mpi4py", "petsc4py", "ufl", "pyvista", "vtk", "vtkmodules"}
class Block:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in blocked or name == "fretfe.fem":
            raise ImportError(f"{name} is blocked in this test")
sys.meta_path.insert(0, Block())
from pathlib import Path
from typing import Any
from fretfe.report.page.html import write_report
print(write_report(Path(sys.argv[1])))
"""


def test_report_needs_neither_pyvista_nor_dolfinx_and_is_always_the_same(
    pages: dict[str, str], tmp_path: Path
) -> None:
    folder = write_run(tmp_path, "halfplane")
    command = [sys.executable, "-c", WITHOUT, str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == str(folder / REPORT)
    assert (folder / REPORT).read_text("utf-8") == pages["halfplane"]


def test_frictionless_contact_has_a_report(tmp_path: Path) -> None:
    """No slip zones, no K_T: what is left is drawn."""
    folder = write_run(tmp_path, "halfplane")

    def edit(numbers: dict) -> None:
        for front in numbers["contacts"]["main"]["fronts"]:
            (edge,) = front["stations"]
            edge.update(slip_zones=[], k_t=[0.0] * len(edge["k_t"]), k_t_range=0.0)
            edge.update(k_range=0.0, k_range_spread=0.0)

    edit_numbers(folder, edit)
    text = render(folder)
    check_alone(text)
    assert "2 edges, no slip zones." in text
    assert 'id="edges"' not in text and 'id="slip"' in text


def test_refinement_is_shown(tmp_path: Path) -> None:

    first, second = (
        StationValues(
            "main",
            "left",
            k_n,
            35.6,
            (0.077, 0.076),
            0.3,
            0.4,
            spreads=(12.0, math.nan, 0.001, 0.06),
        )
        for k_n in (1200.0, 1236.0)
    )
    changes = edge_changes([first], [second], {"main": "main"})
    passes = Pass(1000, 0.01, (first,), False, ()), Pass(2000, 0.01, (second,), True, changes)
    refinement = Refinement(0.01, passes, False, "too <large>")
    write_results(tmp_path, replace(solved("halfplane"), refinement=refinement))
    page = check_alone(render(tmp_path))
    resolved = [row[3:5] for row in page.rows("Changes from mesh to mesh")]
    assert resolved == [["no", "-"], ["yes", "2.91%"]]  # of the newer value
    # nothing without its bar, and nothing whose bar is more than half of it
    limits = ["main", "left", "1236 ± 12", "-", "0.0770 ± 0.0010 / -"]
    assert page.rows("Limits that the meshes tend to") == [limits]
    assert any("not fine enough" in words and "too <large>" in words for words in page.words)
