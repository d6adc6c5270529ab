# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results of solids are read as they were written; their contacts are a file for ParaView too."""

from __future__ import annotations

import html
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from cases.solid_runs import (
    FRICTION,
    NORMAL,
    PEAK,
    SHEAR,
    solid_result,
    stationed_sphere,
    surface,
    write_solid,
)
from cases.stored_runs import write_run

import fretfe
from fretfe.errors import CaseError, OutputError
from fretfe.evaluate.contacts import AreaPatch, Contact
from fretfe.history.solution import OPEN, SLIP, STICK
from fretfe.report.page.tables import contact_table, station_table
from fretfe.report.texts import rounded
from fretfe.results.field_files import FIELDS, SURFACES, FieldReader
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.writer import write_results

SHAPES = {"main": surface(bend=0.3), "quads": surface(bend=0.3, corners=4)}


@pytest.fixture(scope="module")
def result() -> Result:
    return solid_result(shapes=SHAPES)


@pytest.fixture(scope="module")
def folder(result: Result, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("solid")
    write_results(folder, result)
    return folder


def test_areas_are_those_of_the_formulas(result: Result) -> None:
    area = result.contacts[0]
    # Bent by .3 over a radius of 1, a surface carries .985 of Q along x; facets cost .5 %.
    assert area.normal_force[-1] == pytest.approx(NORMAL, rel=0.006)
    assert area.shear_force[:, 0].max() == pytest.approx(SHEAR * FRICTION * NORMAL, rel=0.03)
    assert area.largest_pressure.max() == pytest.approx(PEAK)


def test_summaries_are_read_as_they_were_written(result: Result, folder: Path) -> None:
    loaded = load_result(folder)
    assert loaded.solid and loaded.edges() == []
    assert [each.name for each in loaded.contacts] == ["main", "quads"]
    for mine, other in zip(loaded.contacts, result.contacts, strict=True):
        for field in fields(Contact):
            read, written = (getattr(each, field.name) for each in (mine, other))
            assert type(read) is type(written), field.name
            np.testing.assert_array_equal(read, written, err_msg=field.name)
    # Where nothing presses there is no centre.
    assert np.isnan(loaded.contacts[0].centre[0]).all()


def test_patches_are_read_as_they_were_written(tmp_path: Path) -> None:
    """Also where they cannot be told from one another; tables have rows for them."""
    sphere = stationed_sphere()
    (contact,) = sphere.contacts
    patches = tuple(
        AreaPatch(
            f"main[{which}]",
            np.where(contact.normal_force < NORMAL / 2, np.nan, which * contact.normal_force),
            which * contact.shear_force,
            contact.contact_area,
            reason,
        )
        for which, reason in ((1, ""), (2, "it does not touch"))
    )
    fronts = tuple(replace(front, patch=2) for front in contact.fronts)
    changed = replace(contact, patches=patches, fronts=fronts)
    write_results(tmp_path, replace(sphere, contacts=(changed,)))
    loaded = load_result(tmp_path)
    (found,) = loaded.contacts
    assert [front.patch for front in found.fronts] == [2]
    for mine, other in zip(found.patches, patches, strict=True):
        assert (mine.name, mine.reason) == (other.name, other.reason)
        for name in ("normal_force", "shear_force", "contact_area"):
            np.testing.assert_array_equal(getattr(mine, name), getattr(other, name))
    stations, contacts = station_table(loaded), contact_table(loaded)
    assert stations is not None and "main[2] front 1" in stations.columns[0].cells
    labels, forces, *_ = ([str(cell) for cell in each.cells] for each in contacts.columns)
    assert labels == ["main", "  main[1]", "  main[2]"]
    # A constant stands once.
    assert forces[1:] == [rounded(n * float(contact.normal_force[-1]), 3) for n in (1, 2)]
    # Over the whole history P is unknown in some states.
    whole = contact_table(replace(loaded, loads=replace(loaded.loads, cycle=None)))
    assert list(whole.columns[1].cells)[1:] == ["-", "-"]


def test_contacts_are_read_as_they_were_written(result: Result, folder: Path) -> None:
    loaded = load_result(folder)
    assert loaded.solution.dimension == 3
    for name in SHAPES:
        mine, other = loaded.contact_history(name), result.contact_history(name)
        for pair in ((mine, other), (mine.surface, other.surface)):
            for field in fields(pair[0]):
                read, written = (getattr(each, field.name) for each in pair)
                if field.name not in ("full_stick", "surface", "friction") and written is not None:
                    np.testing.assert_array_equal(read, written, err_msg=field.name)
        assert not mine.friction.differs(other.friction).any()
    facets = loaded.contact_history("quads").surface.facets
    assert facets is not None and facets.shape[1] == 4


def test_histories_of_long_runs_are_read_too(result: Result, tmp_path: Path) -> None:
    """More than 1000 states: vectors stand in the file of arrays."""
    count = 1500
    (area, *_), loads = result.contacts, result.loads
    turning = np.random.default_rng(1).normal(size=(count, 3))
    long: dict[str, Any] = {
        name: turning if each.ndim == 2 else turning[:, 0]
        for name, each in vars(area).items()
        if isinstance(each, np.ndarray) and each.size
    }
    times = np.arange(float(count))
    values = np.zeros((count, 2))
    own = {name: each for name, each in vars(result.solution).items() if name != "between"}
    stretched: dict[str, Any] = {
        name: np.resize(each, (count, *each.shape[1:]))
        for name, each in own.items()
        if isinstance(each, np.ndarray)
    }
    solution = replace(
        result.solution,
        **stretched,
        certificates={n: np.resize(v, count) for n, v in result.solution.certificates.items()},
        cycle=None,
        between=None,
        # Tractions of the first states are kept.
        kept=np.arange(len(loads.times)),
        contacts=tuple(
            replace(
                each,
                friction=each.friction.picked(
                    np.resize(np.arange(len(each.friction.number)), count)
                ),
            )
            for each in result.solution.contacts
        ),
    )
    case = replace(
        result,
        contacts=(replace(area, **long),),
        loads=replace(loads, times=times, values=values, cycle=None, between=None),
        root_solution=solution,
    )
    write_results(tmp_path, case)
    (loaded,) = load_result(tmp_path).contacts
    np.testing.assert_array_equal(loaded.shear_force, turning)
    np.testing.assert_array_equal(loaded.work, turning[:, 0])


def test_records_are_those_of_contacts(result: Result) -> None:
    pytest.importorskip("pandas")
    table = result.to_dataframe()
    assert table["contact"].tolist() == ["main", "quads"]
    assert table["shear_force_x"][0] == result.contacts[0].shear_force[-1, 0]
    card = result._repr_html_()
    assert "stick_area" in card
    assert all(html.escape(line) in card for line in result.headline.sentences.lines)


def test_a_history_of_a_front_that_is_not_there(result: Result) -> None:
    with pytest.raises(CaseError, match=r"one of the fronts \(none\), found main left"):
        result.history("main", "left")


def test_plots_of_solids(result: Result) -> None:
    with pytest.raises(OutputError, match="expected a station with a known range"):
        fretfe.plot_factors(result)


def test_dataset_has_vectors_and_places(result: Result) -> None:
    pytest.importorskip("xarray")
    data = result.to_xarray()
    count = len(result.loads.times)
    assert data.sizes["axis"] == 3 and "edge" not in data.sizes
    assert data["shear_force"].dims == ("contact", "time", "axis")
    assert data["contact_area"].shape == (2, count)
    history = result.contact_history("main")
    assert "main.arc" not in data
    places = np.stack([data[f"main.{axis}"] for axis in "xyz"], axis=1)
    np.testing.assert_array_equal(places, history.surface.points)
    # P from the dataset alone
    total = (data["main.traction"][..., 0] * data["main.weights"]).sum("main.node")
    np.testing.assert_allclose(total, result.contacts[0].normal_force, rtol=1e-12)


def surfaces(folder: Path) -> h5py.File:
    return h5py.File(folder / SURFACES, "r")


def flip(path: Path, table: str) -> None:
    """Change a bit of the first chunk of a data set of a grid."""
    with h5py.File(path, "r") as file:
        chunk = file[f"VTKHDF/{table}"].id.get_chunk_info(0)
    data = bytearray(path.read_bytes())
    data[chunk.byte_offset + chunk.size // 2] ^= 1
    path.write_bytes(data)


def test_changed_fields_are_told(tmp_path: Path) -> None:
    path = write_solid(tmp_path) / FIELDS
    whole = path.read_bytes()
    flip(path, "PointData/stress")
    reader = FieldReader(path)
    assert reader.values("displacement", "upper", 0).shape[-1] == 3
    with pytest.raises(OutputError, match=r"fields\.hdf: cannot read PointData/stress: damaged v"):
        reader.values("stress", "upper", 0)
    path.write_bytes(whole)
    flip(path, "Steps/Values")
    with pytest.raises(OutputError, match=r"fields\.hdf: expected fields of a run, found: damaged"):
        FieldReader(path)


@pytest.mark.parametrize("table", ["Points", "PointData/pressure", "Steps/Values", "Offsets"])
def test_changed_surfaces_are_told(folder: Path, tmp_path: Path, table: str) -> None:
    path = tmp_path / SURFACES
    path.write_bytes((folder / SURFACES).read_bytes())
    flip(path, table)
    with surfaces(tmp_path) as file, pytest.raises(OSError, match="filter returned failure"):
        file[f"VTKHDF/{table}"][:]


def test_surfaces_have_all_contacts_and_kept_states(result: Result, folder: Path) -> None:
    counts = [len(shape.points) for shape in SHAPES.values()]
    with surfaces(folder) as file:
        root = file["VTKHDF"]
        np.testing.assert_array_equal(root["Steps/Values"][:], result.loads.times)
        contact = root["CellData/contact"]
        assert contact.attrs["names"].tolist() == list(SHAPES)
        assert np.bincount(contact[:]).tolist() == [len(s.facets) for s in SHAPES.values()]
        assert set(np.diff(root["Offsets"][:])) == {3, 4}
        assert root["Points"].shape == (sum(counts), 3)
        assert root["Connectivity"][:].max() == sum(counts) - 1
        np.testing.assert_array_equal(root["Points"][: counts[0]], SHAPES["main"].points)
        last = int(root["Steps/PointDataOffsets/status"][-1])
        status = root["PointData/status"][last : last + counts[0], 0]
    np.testing.assert_array_equal(status, result.contact_history("main").status[-1])


def test_vectors_of_surfaces_are_in_the_axes_of_the_case(result: Result, folder: Path) -> None:
    """Shear and slip along the first tangent, which turns with the surface."""
    contact = result.contact_history("main")
    count, state = len(contact.surface.points), 24
    with surfaces(folder) as file:
        root = file["VTKHDF"]
        values = {}
        for name in root["PointData"]:
            start = int(root["Steps/PointDataOffsets"][name][state])
            values[name] = root["PointData"][name][start : start + count].astype(float)
    angle = 0.3 * SHAPES["main"].plane[:, 0]
    tangent = np.stack([np.cos(angle), -np.sin(angle), 0 * angle], axis=1)
    for name, along in (
        ("shear", contact.mean_traction[state, :, 1]),
        ("slip", contact.slip[state, :, 0]),
    ):
        expected = along[:, None] * tangent
        np.testing.assert_allclose(values[name], expected, atol=1e-6 * np.abs(along).max())
    work = values["dissipation"][:, 0] @ contact.surface.weights
    assert work == pytest.approx(result.contacts[0].work[state], rel=1e-6) and work > 0


def test_surfaces_have_the_states_that_are_kept(tmp_path: Path) -> None:
    result = solid_result(tractions="extremes")
    write_results(tmp_path, result)
    loaded = load_result(tmp_path)
    assert loaded.solution.kept is not None
    kept = loaded.solution.kept
    assert len(kept) < len(result.loads.times)
    with surfaces(tmp_path) as file:
        np.testing.assert_array_equal(file["VTKHDF/Steps/Values"][:], result.loads.times[kept])
    # Written again from what was read
    write_results(tmp_path, loaded)
    with surfaces(tmp_path) as file:
        assert len(file["VTKHDF/Steps/Values"]) == len(kept)


@pytest.mark.pictures
def test_pyvista_reads_surfaces(folder: Path, result: Result) -> None:
    pyvista = pytest.importorskip("pyvista")
    reader = pyvista.get_reader(folder / SURFACES).reader
    reader.UpdateInformation()
    reader.UpdateTimeStep(2.25)
    grid = pyvista.wrap(reader.GetOutputDataObject(0))
    sizes = grid.compute_cell_sizes(length=False, volume=False)["Area"]
    assert sizes[grid.cell_data["contact"] == 1].sum() == pytest.approx(9.0, rel=1e-3)
    state = int(np.flatnonzero(result.loads.times == 2.25)[0])
    found = np.bincount(grid.point_data["status"].ravel(), minlength=3)
    expected = sum(np.bincount(result.contact_history(n).status[state]) for n in SHAPES)
    assert [OPEN, STICK, SLIP] == [0, 1, 2]
    np.testing.assert_array_equal(found, expected)


def test_plane_bodies_have_no_surfaces(tmp_path: Path) -> None:
    write_solid(tmp_path)
    assert (tmp_path / SURFACES).exists()
    write_run(tmp_path, "halfplane")
    assert not (tmp_path / SURFACES).exists()
