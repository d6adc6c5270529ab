# SPDX-License-Identifier: LGPL-3.0-or-later
"""The pictures of a results folder: `pictures/*.png`, and `pictures/pictures.json` that lists them.

Stress is drawn by another process, which may crash where OpenGL does not work: pictures that cannot
be made are listed with the reason.
"""

from __future__ import annotations

import base64
import itertools
import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np

from fretfe.environment import idle_cores
from fretfe.errors import OutputError
from fretfe.report.pictures.child import draw_in_child
from fretfe.report.pictures.panels import save_png
from fretfe.report.pictures.status import draw_status
from fretfe.report.source import edge_title, extremes, folder_of
from fretfe.results.field_file import FIELDS
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.writer import PICTURE_LIST, PICTURES, remove_pictures

T = TypeVar("T")

# Panels in one picture.
MOST_EDGES, MOST_CONTACTS = 4, 4

NO_FIELDS = (
    f"there is no {FIELDS}: 'fields' in the table [output] of the case says which states a run "
    'writes; "extremes" suits pictures'
)

Kind = Literal["bodies", "edges", "status"]


@dataclass(frozen=True)
class EdgePlace:
    """An edge of a contact, at the last state.

    Attributes:
        contact: name.
        title: of its panel.
        position: along the arc.
        slip: length of the longer one of its last two slip zones; 0 if there is none.
        half_width: of the contact.
    """

    contact: str
    title: str
    position: float
    slip: float
    half_width: float


@dataclass(frozen=True)
class Wanted:
    """A picture to make.

    Attributes:
        file: its name.
        title: what it shows.
        kind: of picture.
        states: that it shows.
        edges: that it shows, one panel each.
        contacts: that it shows, one row of panels each.
    """

    file: str
    title: str
    kind: Kind
    states: tuple[int, ...]
    edges: tuple[EdgePlace, ...] = ()
    contacts: tuple[str, ...] = ()


def plan_pictures(run: Result) -> list[Wanted]:
    """The pictures that a run should have."""
    states = tuple(extremes(run))
    last = len(run.loads.times) - 1
    bodies = Wanted("stress.png", "Stress in the bodies at the load extremes", "bodies", states)
    edges = [
        Wanted(f"edges{mark}.png", f"Stress at the contact edges{part}", "edges", (last,), chunk)
        for mark, part, chunk in _chunks(_edge_places(run), MOST_EDGES) or [("", "", ())]
    ]
    status = [
        Wanted(
            f"status{mark}.png", f"Stick and slip at the load extremes{part}", "status", states,
            contacts=chunk,
        )
        for mark, part, chunk in _chunks([each.name for each in run.contacts], MOST_CONTACTS)
    ]  # fmt: skip
    return [bodies, *edges, *status]


def _chunks(items: Sequence[T], most: int) -> list[tuple[str, str, tuple[T, ...]]]:
    """Parts of about equal size, with what to add to the name of a file and to a title."""
    count = -(-len(items) // most)
    limits = [round(number * len(items) / count) for number in range(count + 1)] if count else []
    parts = [tuple(items[low:high]) for low, high in itertools.pairwise(limits)]
    if count < 2:
        return [("", "", part) for part in parts]
    return [(f"_{number}", f" ({number} of {count})", part) for number, part in enumerate(parts, 1)]


def _edge_places(run: Result) -> list[EdgePlace]:
    """All edges that the last state has."""
    places = []
    for contact in run.contacts:
        for edge in contact.stations:
            position, half_width = float(edge.position[-1]), float(contact.half_width[-1])
            if np.isfinite([position, half_width]).all():
                lengths = [zone.length for zone in edge.slip_zones[-2:] if not zone.gross]
                slip = float(max(lengths, default=0.0))
                title = f"{contact.name}, {edge_title(edge)}"
                places.append(EdgePlace(contact.name, title, position, slip, half_width))
    return places


def make_pictures(directory: Path, meanwhile: Callable[[], None] = lambda: None) -> None:
    """Draw what a run has computed, as far as this machine can.

    Args:
        directory: results folder.
        meanwhile: other work, which is done while other processes draw if cores are idle.

    Raises:
        OutputError: if the results cannot be read or the folder cannot be written to.
    """
    remove_pictures(directory)
    run = load_result(directory)
    wanted = plan_pictures(run)
    reports = {each.file: {"reason": reason} for each in wanted if (reason := _lacks(run, each))}
    try:
        (directory / PICTURES).mkdir(exist_ok=True)
        missing = [each for each in wanted if each.file not in reports]
        reports |= _draw(run, missing, meanwhile)
        _write_list(directory, wanted, reports)
    except OSError as error:
        raise OutputError(f"{directory / PICTURES}: cannot write pictures: {error}") from error


def _lacks(run: Result, wanted: Wanted) -> str:
    """The reason why there cannot be a picture; empty if there can."""
    if not run.bodies:
        return f"the backend {run.backend!r} has no bodies to draw"
    if wanted.kind == "edges" and not wanted.edges:
        return "the last state has no contact edges, or too few nodes in contact to find them"
    return ""


def _draw(
    run: Result, wanted: Sequence[Wanted], meanwhile: Callable[[], None]
) -> dict[str, dict[str, Any]]:
    """Caption and size of each picture, or the reason why there is none."""
    files = [each.file for each in wanted if each.kind != "status"]
    reports: dict[str, dict[str, Any]] = {}
    if not (folder_of(run) / FIELDS).exists():
        reports |= {file: {"reason": NO_FIELDS} for file in files}
        files = []
    idle = idle_cores()
    if not idle:
        meanwhile()
    # The threads only wait for their processes.
    with ThreadPoolExecutor(max(idle, 1)) as waiting:
        shares = [files[first :: max(idle, 1)] for first in range(min(len(files), max(idle, 1)))]
        drawn = [
            waiting.submit(draw_in_child, "pictures", folder_of(run), share) for share in shares
        ]
        if idle:
            meanwhile()
        reports |= {each.file: _draw_status(run, each) for each in wanted if each.kind == "status"}
        for share in drawn:
            reports |= share.result()
    return reports


def _draw_status(run: Result, wanted: Wanted) -> dict[str, Any]:
    figure, caption = draw_status(run, wanted.contacts, wanted.states)
    width, height = save_png(figure, folder_of(run) / PICTURES / wanted.file)
    return {"caption": caption, "width": width, "height": height}


def _write_list(
    directory: Path, wanted: Sequence[Wanted], reports: Mapping[str, Mapping[str, Any]]
) -> None:
    pictures, missing = [], []
    for each in wanted:
        report = dict(reports[each.file])
        if "reason" in report:
            missing.append({"title": each.title, "reason": report.pop("reason")})
        if report:
            pictures.append({"file": each.file, "title": each.title, **report})
    text = json.dumps({"pictures": pictures, "missing": missing}, indent=1, ensure_ascii=False)
    (directory / PICTURES / PICTURE_LIST).write_text(text + "\n", encoding="utf-8")


@dataclass(frozen=True)
class Picture:
    """A picture, its bytes in the page itself.

    Attributes:
        title: what it shows.
        caption: how to read it.
        source: data URI.
        width: in pixels.
        height: in pixels.
    """

    title: str
    caption: str
    source: str
    width: int
    height: int


@dataclass(frozen=True)
class Missing:
    """Pictures that could not be made, and why."""

    titles: tuple[str, ...]
    reason: str


@dataclass(frozen=True)
class Pictures:
    """All pictures in their order."""

    shown: tuple[Picture, ...] = ()
    missing: tuple[Missing, ...] = ()


def read_pictures(directory: Path) -> Pictures:
    """Pictures of a results folder; none if it has no list of them.

    Raises:
        OutputError: if the list, or a picture in it, cannot be read.
    """
    folder = directory / PICTURES
    path = folder / PICTURE_LIST
    if not path.exists():
        return Pictures()
    try:
        listed = json.loads(path.read_text(encoding="utf-8"))
        shown = tuple(
            Picture(
                each["title"],
                each["caption"],
                _data_uri(folder / Path(each["file"]).name),
                int(each["width"]),
                int(each["height"]),
            )
            for each in listed["pictures"]
        )
        reasons: dict[str, list[str]] = {}
        for each in listed["missing"]:
            reasons.setdefault(each["reason"], []).append(each["title"])
        missing = tuple(Missing(tuple(titles), reason) for reason, titles in reasons.items())
    except (OSError, AttributeError, KeyError, TypeError, ValueError) as error:
        found = f"no key {error}" if isinstance(error, KeyError) else str(error)
        raise OutputError(f"{path}: expected a list of pictures, found: {found}") from error
    return Pictures(shown, missing)


def _data_uri(path: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")
