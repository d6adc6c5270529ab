# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of a results folder: what is listed is there, and what cannot be drawn has a reason."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import sys
import threading
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.drawn import fields, write_folder
from cases.stored_runs import edit_numbers
from matplotlib import colormaps
from matplotlib.colors import to_rgb
from matplotlib.image import imread

from fretfe.history.solution import SLIP, STICK
from fretfe.report.pictures import folder as folder_module
from fretfe.report.pictures.fields import open_fields
from fretfe.report.pictures.folder import _run, make_pictures
from fretfe.report.pictures.looks import MOST_EDGES, find_look, plan_pictures
from fretfe.report.pictures.mesh import STATUS
from fretfe.report.pictures.panels import Pixels, View
from fretfe.report.pictures.render import draw_bodies
from fretfe.results.field_files import FIELDS
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.writer import PICTURE_LIST, PICTURES

# Load extremes and end of the last cycle, from t = 2 to t = 3.
EXTREMES = (2.25, 2.75, 3.0)
STRESS = ["Stress in the bodies at the load extremes", "Stress at the contact edges"]


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_folder(tmp_path_factory.mktemp("pictures") / "results", EXTREMES)


@pytest.fixture(scope="module")
def drawn(source: Path) -> Path:
    """The folder with its pictures, if they can be drawn here."""
    if importlib.util.find_spec("pyvista") is None:
        pytest.skip("PyVista is not installed")
    make_pictures(source)
    missing = listed(source)["missing"]
    if missing and "OpenGL" in missing[0]["reason"]:
        pytest.skip(missing[0]["reason"])
    return source


@pytest.fixture
def folder(source: Path, tmp_path: Path) -> Path:
    """A copy to change."""
    return shutil.copytree(source, tmp_path / "copy", ignore=shutil.ignore_patterns(PICTURES))


def listed(folder: Path) -> dict[str, Any]:
    return dict(json.loads((folder / PICTURES / PICTURE_LIST).read_text("utf-8")))


def reasons(folder: Path) -> dict[str, str]:
    make_pictures(folder)
    return {each["title"]: each["reason"] for each in listed(folder)["missing"]}


def test_every_picture_is_there_and_as_large_as_the_list_says(drawn: Path) -> None:
    content = listed(drawn)
    assert content["missing"] == []
    names = [each["file"] for each in content["pictures"]]
    assert names == ["stress.png", "edges.png", "status.png"]
    assert sorted(path.name for path in (drawn / PICTURES).iterdir()) == sorted(
        [*names, PICTURE_LIST]
    )
    for each in content["pictures"]:
        height, width = imread(drawn / PICTURES / each["file"]).shape[:2]
        assert (each["width"], each["height"]) == (width, height)
        assert width <= 1600
    assert sum((drawn / PICTURES / name).stat().st_size for name in names) < 3e6


def test_captions_tell_states_scale_and_where_colours_end(drawn: Path) -> None:
    bodies, edges, status = (each["caption"] for each in listed(drawn)["pictures"])
    assert all("t = 2.25 s and t = 2.75 s" in each for each in (bodies, edges, status))
    # The initial gap at the edges, a²/2R = 3.3e-3 mm, may overlap by 0.3 % of 6 mm: 6.4 times.
    assert "displacements enlarged 5 times" in bodies
    # √(1 − ν + ν²) (100 + 10 · 3 · 2.75) MPa = 162.2 MPa at x = 3 mm
    assert "The largest stress is 162 MPa" in bodies
    assert not any(mark in text for text in (bodies, edges, status) for mark in "<>*_`")


class Blank:
    """A scene without bodies, to learn where panels are."""

    def image(self, *arguments: Any) -> Pixels:
        width, height = arguments[-1]
        return np.zeros((height, width, 3), dtype=np.uint8)


def test_colours_are_where_the_stress_is(drawn: Path) -> None:
    """Pixels of the picture against the colour map at the stress of these places."""
    image = imread(drawn / "pictures" / "stress.png")[..., :3]
    source = open_fields(drawn)
    look = find_look(source, [7, 9])
    view = look.views[0]
    assert isinstance(view, View)
    figure = draw_bodies(source, [7, 9], look, Blank())  # type: ignore[arg-type]
    assert np.floor(figure.bbox.size).tolist() == [image.shape[1], image.shape[0]]
    for axes, time in zip(figure.axes, (2.25, 2.75), strict=False):
        box = axes.get_window_extent()
        # Images are drawn for whole pixels.
        assert box.extents == pytest.approx(np.round(box.extents), abs=1e-6)
        for place in np.array([(-1.5, 1.2), (1.5, 1.2), (-2.3, -1.2), (2.3, -0.7)]):
            displacement, stress = fields(place[None], time)
            seen = view.local(place + look.scale * displacement[0]) - view.origin
            part = (seen / view.half_size + 1) / 2
            column = box.x0 + part[0] * box.width
            row = image.shape[0] - (box.y0 + part[1] * box.height)
            von_mises = np.sqrt(1 - 0.3 + 0.09) * stress[0, 0]
            expected = colormaps["viridis"](von_mises / look.limit)[:3]
            # The palette has 216 tones, which are up to 0.01 apart.
            assert image[int(row), int(column)] == pytest.approx(expected, abs=0.02)


def test_status_has_its_colours(drawn: Path) -> None:
    pixels = imread(drawn / PICTURES / "status.png")[..., :3].reshape(-1, 3)
    for kind in (STICK, SLIP):
        # Anti-aliased lines have pure pixels inside; 8 bits are exact to 1/510.
        same = np.abs(pixels - to_rgb(STATUS[kind]["color"])).max(axis=1) < 0.003
        assert same.any()


def test_without_fields_stress_is_missing(folder: Path) -> None:
    (folder / FIELDS).unlink()
    found = reasons(folder)
    assert list(found) == STRESS
    assert all('"extremes"' in reason for reason in found.values())
    assert [each["file"] for each in listed(folder)["pictures"]] == ["status.png"]


def test_states_without_fields_are_named(drawn: Path, tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "last", EXTREMES[2:])
    found = reasons(folder)
    assert found == dict.fromkeys(STRESS, "no fields of t = 2.25 s and t = 2.75 s in fields.hdf")
    assert [each["file"] for each in listed(folder)["pictures"]] == ["status.png"]


def test_backends_without_bodies_have_no_pictures(folder: Path) -> None:
    edit_numbers(folder, lambda numbers: numbers.update(mesh={}, backend="halfplane"))
    found = reasons(folder)
    assert set(found.values()) == {"the backend 'halfplane' has no bodies to draw"}
    assert listed(folder)["pictures"] == []


def test_contacts_without_edges_are_told_apart(folder: Path) -> None:
    def forget(numbers: dict[str, Any]) -> None:
        for front in numbers["contacts"]["main"]["fronts"]:
            (edge,) = front["stations"]
            edge["position"] = [None] * len(edge["position"])

    (folder / FIELDS).unlink()
    edit_numbers(folder, forget)
    found = reasons(folder)
    assert list(found) == STRESS
    assert "no contact edges" in found[STRESS[1]] and "fields" in found[STRESS[0]]


BROKEN = {
    "no PyVista": ("raise ModuleNotFoundError(\"No module named 'pyvista'\")", "pip install pyv"),
    "a library is missing": ("raise ImportError('libXrender.so.1: not found')", "libXrender.so.1"),
    "crash": ("import os\nos.abort()", "libegl1"),
    "crash of OpenGL": ("import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)", "xvfb"),
    "killed": ("import os, signal\nos.kill(os.getpid(), signal.SIGKILL)", "ended with SIGKILL"),
}


@pytest.mark.parametrize("kind", list(BROKEN))
def test_what_cannot_be_drawn_has_a_reason(
    folder: Path, kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code, expected = BROKEN[kind]
    (tmp_path / "pyvista.py").write_text(code + "\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    found = reasons(folder)
    assert list(found) == STRESS
    assert all(expected in reason for reason in found.values())
    assert [each["file"] for each in listed(folder)["pictures"]] == ["status.png"]


def test_a_display_is_made_where_there_is_none(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first process crashes; the second one, with a display, goes on to another error."""
    code = "import os\nif 'MADE' not in os.environ:\n    os.abort()\nraise ValueError('seen')\n"
    (tmp_path / "pyvista.py").write_text(code)
    launcher = tmp_path / "xvfb-run"
    launcher.write_text('#!/bin/sh\n[ "$1" = -a ] && shift\nexec env MADE=1 "$@"\n')
    launcher.chmod(0o755)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(shutil, "which", lambda _: str(launcher))
    assert set(reasons(folder).values()) == {
        "fretfe itself failed (ValueError: seen): please report that"
    }


def test_a_display_is_not_tried_without_xauth(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "pyvista.py").write_text("import os\nos.abort()\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(shutil, "which", {"xvfb-run": "/bin/false"}.get)
    assert all("xvfb and xauth" in reason for reason in reasons(folder).values())


def test_without_opengl_there_is_a_reason(
    drawn: Path, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """VTK itself, told to use a window that does not exist, and no display to be had."""
    monkeypatch.setattr(shutil, "which", lambda _: None)
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "none")
    monkeypatch.setenv("MESA_GL_VERSION_OVERRIDE", "1.0")
    monkeypatch.delenv("DISPLAY", raising=False)
    found = reasons(folder)
    assert list(found) == STRESS
    assert all("OpenGL" in reason for reason in found.values())


def test_what_was_drawn_before_a_crash_counts() -> None:
    code = """print('{"file": "a", "width": 3}', flush=True); print("x"); import os; os.abort()"""
    reports, reason = _run([sys.executable, "-c", code], 60)
    assert reports == {"a": {"width": 3}}
    assert "SIGABRT" in reason


def test_drawing_ends_after_its_time() -> None:
    code = "import time; time.sleep(60)"
    assert _run([sys.executable, "-c", code], 0.5) == ({}, "drawing took more than 0.5 s")


def test_a_drawing_process_knows_nothing_of_mpi(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("PMI_RANK", "PMIX_RANK", "OMPI_COMM_WORLD_SIZE", "MPI_LOCALNRANKS", "HYDI_X"):
        monkeypatch.setenv(name, "1")
    code = "import json, os; print(json.dumps({'file': 'names', 'all': list(os.environ)}))"
    reports, _ = _run([sys.executable, "-c", code], 60)
    assert "PATH" in reports["names"]["all"] or "PATH" not in os.environ
    prefixes = ("PMI", "OMPI", "MPI_", "HYDI")
    assert not [name for name in reports["names"]["all"] if name.startswith(prefixes)]


def test_an_earlier_run_leaves_nothing(folder: Path) -> None:
    (folder / PICTURES).mkdir()
    for path in (PICTURES + "/old.png", PICTURES + "/mine.txt", FIELDS):
        (folder / path).write_text("")
    (folder / FIELDS).unlink()
    make_pictures(folder)
    assert not (folder / FIELDS).exists()
    kept = sorted(path.name for path in (folder / PICTURES).iterdir())
    assert kept == ["mine.txt", PICTURE_LIST, "status.png"]


@pytest.mark.parametrize("idle", [0, 1, 3])
def test_other_work_is_done_while_processes_draw(
    folder: Path, monkeypatch: pytest.MonkeyPatch, idle: int
) -> None:
    """No more processes at a time than idle cores, each picture once; without any, one by one."""
    events: list[str] = []
    running: list[Sequence[str]] = []
    most: list[int] = []

    def draw(directory: Path, files: Sequence[str]) -> dict[str, dict[str, Any]]:
        running.append(files)
        most.append(len(running))
        if idle:
            assert worked.wait(10)
        running.remove(files)
        events.extend(files)
        return {file: {"reason": "of the test"} for file in files}

    def work(_: Result) -> None:
        events.append("work")
        worked.set()

    worked = threading.Event()
    monkeypatch.setattr(folder_module, "draw_in_child", draw)
    monkeypatch.setattr(folder_module, "idle_cores", lambda: idle)
    make_pictures(folder, work)
    assert events[0] == "work"
    assert sorted(events[1:]) == ["edges.png", "stress.png"]
    assert max(most) <= max(idle, 1)


def test_many_contacts_share_pictures(source: Path) -> None:
    """Six contacts with twelve edges at two states, each once, in eight pictures at most."""
    run = load_result(source)
    names = [f"tooth {i}" for i in range(6)]
    contacts = tuple(replace(run.contacts[0], name=name) for name in names)
    wanted = plan_pictures(replace(run, contacts=contacts))
    assert len(wanted) <= 8 and len({each.file for each in wanted}) == len(wanted)
    edges = [(edge.title, edge.state) for each in wanted for edge in each.edges]
    sides = [f"{name}, {side} edge" for name in names for side in ("left", "right")]
    assert edges == [(side, state) for side in sides for state in wanted[0].states]
    assert max(len(each.edges) for each in wanted) <= MOST_EDGES
    assert [name for each in wanted for name in each.contacts] == names
