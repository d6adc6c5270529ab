# SPDX-License-Identifier: LGPL-3.0-or-later
"""`fretfe export`: tables that other programs read have the numbers of the result."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import get_type_hints

import numpy as np
import pandas as pd
import pytest
from cases.pad_cases import HOLD, TOP, pad, press
from cases.solid_runs import NORMAL, write_solid
from cases.stored_runs import solved, write_run
from harness.launch import fretfe as command

import fretfe
from fretfe._typing import Array, Indices
from fretfe.case import Units, parse_case
from fretfe.errors import CaseError, ConvergenceError, OutputError
from fretfe.evaluate.contacts import AreaPatch, Contact, Station, quantities
from fretfe.exchange import export
from fretfe.exchange.export import headings
from fretfe.results import quantities as contents
from fretfe.results.model import Result
from fretfe.results.writer import write_results

# Hertz: R = 50, P = 600, two equal bodies of steel.
E_STAR = 210e3 / (2 * (1 - 0.3**2))
HALF_WIDTH = np.sqrt(4 * 50 * 600 / (np.pi * E_STAR))
K_N = E_STAR / (2 * 50) * np.sqrt(2 * HALF_WIDTH)
GUIDE = (Path(__file__).parents[2] / "docs" / "exchange.md").read_text("utf-8")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_run(tmp_path_factory.mktemp("run"), "halfplane")


@pytest.fixture(scope="module")
def tables(run: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, pd.DataFrame]:
    folder = tmp_path_factory.mktemp("tables")
    return read(fretfe.export(fretfe.load_result(run), folder))


def read(files: tuple[Path, ...]) -> dict[str, pd.DataFrame]:
    return {path.name: pd.read_csv(path) for path in files}


def test_tables_of_plane_bodies(tables: dict[str, pd.DataFrame]) -> None:
    assert list(tables) == [
        "loads.csv", "contacts.csv", "factors.csv", "edges.csv", "stations.csv", "tractions.csv",
        "local.csv", "columns.csv",
    ]  # fmt: skip
    edges = tables["edges.csv"]
    # A closed form; the fit of the pressure of a fine half-plane is good to .02 %.
    assert edges["k_n [MPa/mm^0.5]"].to_numpy() == pytest.approx(K_N, rel=2e-4)
    loads = tables["loads.csv"]
    assert loads["press [N]"].iloc[-1] == -600 and loads["shear [N]"].max() == pytest.approx(60)


def test_tractions_are_those_of_the_resultants(tables: dict[str, pd.DataFrame]) -> None:
    tractions, contacts = tables["tractions.csv"], tables["contacts.csv"].set_index("state")
    for state, rows in tractions.groupby("state"):
        x, p, q = (rows[name].to_numpy() for name in ("x [mm]", "p [MPa]", "q [MPa]"))
        # Trapezoids below a root at either end.
        for values, name in ((p, "normal_force [N/mm]"), (q, "shear_force [N/mm]")):
            sum_ = float(((values[1:] + values[:-1]) / 2 * np.diff(x)).sum())
            assert sum_ == pytest.approx(contacts[name][state], rel=2e-3, abs=0.1)


def test_what_does_not_exist_is_empty(run: Path, tmp_path: Path) -> None:
    result = fretfe.load_result(run)
    fretfe.export(result, tmp_path)
    # Not by pandas, of which some versions read numbers to one unit in the last place.
    with (tmp_path / "factors.csv").open(encoding="utf-8", newline="") as file:
        left = [row["k_n [MPa/mm^0.5]"] for row in csv.DictReader(file) if row["front"] == "left"]
    k_n = [float(text) if text else np.nan for text in left]
    np.testing.assert_array_equal(k_n, result.contacts[0].stations[0].k_n)
    assert np.isnan(k_n[0])


def test_edges_are_stations_too(tables: dict[str, pd.DataFrame]) -> None:
    edges, stations = tables["edges.csv"], tables["stations.csv"]
    assert list(stations["front"]) == list(edges["edge"]) == ["left", "right"]
    assert set(stations["verdict"]) == {"agrees"} and set(stations["station"]) == {0}
    for name in ("position [mm]", "k_n [MPa/mm^0.5]"):
        np.testing.assert_array_equal(stations[name], edges[name])
    # The interface of half-planes is the x axis, which is the arc.
    np.testing.assert_allclose(stations["x [mm]"], stations["position [mm]"], atol=1e-12)
    assert (
        list(stations["inward_x"]) == [1, -1]
        and not stations[["y [mm]", "z [mm]"]].to_numpy().any()
    )


def test_all_columns_are_listed_and_documented(tables: dict[str, pd.DataFrame]) -> None:
    listing = tables["columns.csv"]
    for name, table in tables.items():
        if name != "columns.csv":
            own = listing[listing["file"] == name]
            assert list(own["header"]) == list(table.columns)
            assert own["meaning"].str.len().min() > 3
    named = [contents.STATION, contents.CONTACTS, contents.FACTORS, contents.EDGES]
    named += [contents.CYCLES, contents.STATIONS, export.PLANE_TRACTIONS, export.SOLID_TRACTIONS]
    for each in {column.name for group in named for column in group}:
        stem = each.removesuffix("_x").removesuffix("_y").removesuffix("_z")
        assert f"`{each}`" in GUIDE or f"`{stem}_x`" in GUIDE, each
    for kind in ("k_n", "k_t"):
        assert contents.UNITS[kind] == contents.SOLID_UNITS[kind]


@pytest.mark.parametrize("owner", [Station, Contact])
def test_every_number_has_a_unit_and_a_meaning(owner: type) -> None:
    types = (Array, Indices, float, int, bool)
    numbers = {name for name, kind in get_type_hints(owner).items() if kind in types}
    declared = quantities(owner)
    assert len(numbers) > 10 and numbers <= declared.keys()
    for each in declared.values():
        assert each.kind in contents.UNITS and len(each.meaning) > 10


def test_units_are_those_of_the_case() -> None:
    units = Units(length="in", force="lbf", stress="psi", time="min")
    one, two = (
        headings((*contents.STATION, *export.STATE, *contents.CONTACTS), units, solid=solid)
        for solid in (False, True)
    )
    texts = {heading.name: heading.text for heading in one}
    assert texts["time"] == "time [min]" and texts["normal_force"] == "normal_force [lbf/in]"
    assert texts["moment"] == "moment [lbf]" and texts["contact"] == "contact"
    assert {heading.name: heading.unit for heading in two}["moment"] == "lbf*in"
    factors = {each.name: each.unit for each in headings(contents.FACTORS, units, solid=False)}
    assert (factors["k_n"], factors["k_t"]) == ("psi/in^0.5", "psi*in^0.5")


def under_irregular_loads() -> Result:
    points = [(1.0, 0.0), (2.0, 60.0), (3.0, 10.0), (4.0, 40.0), (5.0, -30.0), (6.0, 0.0)]
    history = [HOLD, *({"ramp": q, "until": t, "steps": 2} for t, q in points[1:])]
    loads = {"press": press(), "shear": {**TOP, "direction": "x", "history": history}}
    return fretfe.run(parse_case(pad(loads=loads)), "halfplane")


def test_irregular_loads_have_a_table_of_cycles(tmp_path: Path) -> None:
    found = read(fretfe.export(under_irregular_loads(), tmp_path))
    cycles = found["cycles.csv"]
    (worst,) = cycles.query("front == 'left' and worst == 1")["k_t_range [MPa*mm^0.5]"]
    # From Q = 60 to -30, by (4).
    assert worst == pytest.approx(90 / (np.pi * np.sqrt(2 * HALF_WIDTH)), rel=1e-3)


def test_tables_of_an_earlier_export_do_not_stay(run: Path, tmp_path: Path) -> None:
    own, earlier = tmp_path / "notes.csv", tmp_path / "cycles.csv"
    own.write_text("mine")
    fretfe.export(under_irregular_loads(), tmp_path)
    assert earlier.exists()
    fretfe.export(fretfe.load_result(run), tmp_path)
    assert not earlier.exists() and own.read_text() == "mine"


def test_a_listing_leads_nowhere_else(run: Path, tmp_path: Path) -> None:
    outside = tmp_path / "outside.csv"
    outside.write_text("mine")
    folder = tmp_path / "tables"
    folder.mkdir()
    (folder / "columns.csv").write_text("file,header,column,unit,meaning\n../outside.csv,,,,\n")
    fretfe.export(fretfe.load_result(run), folder)
    assert outside.read_text() == "mine"


@pytest.mark.parametrize("name", ["loads.csv", "columns.csv"])
def test_files_of_others_are_not_replaced(run: Path, tmp_path: Path, name: str) -> None:
    """`-o .` beside a case whose loads are in loads.csv; not a list of ours, and no text."""
    own = tmp_path / name
    own.write_bytes("Lastfälle,t\n".encode("latin-1"))
    with pytest.raises(
        CaseError, match=rf"{name}: expected .* export, found something else|others"
    ):
        fretfe.export(fretfe.load_result(run), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert own.read_bytes().startswith(b"Lastf\xe4lle")


def test_an_export_that_was_cut_off_is_done_again(run: Path, tmp_path: Path) -> None:
    result = fretfe.load_result(run)
    fretfe.export(result, tmp_path)
    (tmp_path / "factors.csv").unlink()
    assert len(fretfe.export(result, tmp_path)) == 8


def test_solids(tmp_path: Path) -> None:
    found = read(fretfe.export(fretfe.load_result(write_solid(tmp_path / "run")), tmp_path / "out"))
    contacts = found["contacts.csv"]
    # Facets cost .5 %.
    assert contacts["normal_force [N]"].iloc[-1] == pytest.approx(NORMAL, rel=0.006)
    nodes = found["tractions.csv"].query("state == 4")
    normal = nodes[[f"normal_{axis}" for axis in "xyz"]].to_numpy()
    shear = nodes[[f"q_{axis} [MPa]" for axis in "xyz"]].to_numpy()
    np.testing.assert_allclose((normal * shear).sum(axis=1), 0, atol=1e-9)
    assert nodes["p [MPa]"].max() == pytest.approx(300)


def test_patches_of_solids_have_rows(tmp_path: Path) -> None:
    """Below their contact, with what is known of a patch."""
    result = fretfe.load_result(write_solid(tmp_path / "run"))
    (contact,) = result.contacts
    force, shear, area = contact.normal_force / 2, contact.shear_force, contact.contact_area
    patch = AreaPatch("main[1]", force, shear, area, "")
    found = read(
        fretfe.export(replace(result, contacts=(replace(contact, patches=(patch,)),)), tmp_path)
    )
    rows = found["contacts.csv"]
    whole, own = (rows[rows["contact"] == name] for name in ("main", "main[1]"))
    assert len(whole) == len(own) == len(result.loads.times)
    np.testing.assert_allclose(own["normal_force [N]"], force)
    np.testing.assert_allclose(own["shear_force_x [N]"], shear[:, 0])
    assert own["largest_pressure [MPa]"].isna().all() and whole["work [N*mm]"].notna().all()


def test_command(run: Path, tmp_path: Path) -> None:
    done = command("export", run, "-o", tmp_path / "out")
    assert done.returncode == 0
    assert f"{tmp_path / 'out' / 'edges.csv'}: 2 rows" in done.stdout
    with (tmp_path / "out" / "edges.csv").open() as file:
        assert len(list(csv.reader(file))) == 3


def test_a_run_that_ended_early_says_so(tmp_path: Path) -> None:
    run = tmp_path / "run"
    run.mkdir()
    write_results(run, replace(solved("halfplane"), failure=ConvergenceError("step 12 [b]")))
    done = command("export", run, "-o", tmp_path / "out")
    assert "Note: the run is not complete: step 12 [b]" in done.stdout


def test_mistakes(run: Path, tmp_path: Path) -> None:
    result = fretfe.load_result(run)
    with pytest.raises(CaseError, match="expected a folder without results of a run"):
        fretfe.export(result, run)
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="expected a folder that files can be written to"):
        fretfe.export(result, tmp_path / "file")
    done = command("export", run, "-o", "x" * 5000)
    assert done.returncode == 6 and "File name too long" in done.stderr
    done = command("export", tmp_path / "file", "-o", tmp_path / "out")
    assert done.returncode == 6 and "no readable results.json: Not a directory" in done.stderr
    done = command("export", tmp_path / "none", "-o", tmp_path / "out")
    assert done.returncode == 6 and "expected a folder with the results" in done.stderr
