# SPDX-License-Identifier: LGPL-3.0-or-later
"""The pictures of a results folder: `pictures/*.png`, and `pictures/pictures.json` that lists them.

What needs OpenGL is drawn by another process (`fretfe.report.render`), which may crash: pictures
that cannot be made are listed with the reason.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from fretfe.errors import OutputError
from fretfe.report.child import draw_in_child
from fretfe.report.picture_frames import save_png
from fretfe.report.picture_plan import FOLDER, LIST, Wanted, plan_pictures
from fretfe.report.status_pictures import draw_status
from fretfe.results.model import Result
from fretfe.results.reader import load_result, read_numbers
from fretfe.results.writer import FIELDS


def make_pictures(directory: Path) -> None:
    """Draw what a run has computed, as far as this machine can.

    Args:
        directory: results folder.

    Raises:
        OutputError: if the results cannot be read or the folder cannot be written to.
    """
    remove_pictures(directory)
    numbers = read_numbers(directory)
    wanted = plan_pictures(numbers)
    reports = {
        each.file: {"reason": reason} for each in wanted if (reason := _lacks(numbers, each))
    }
    try:
        (directory / FOLDER).mkdir(exist_ok=True)
        reports |= _draw(directory, numbers, [each for each in wanted if each.file not in reports])
        _write_list(directory, wanted, reports)
    except OSError as error:
        raise OutputError(f"{directory / FOLDER}: cannot write pictures: {error}") from error


def remove_pictures(directory: Path) -> None:
    """Remove the pictures of an earlier run; other files stay."""
    folder = directory / FOLDER
    for path in [*folder.glob("*.png"), folder / LIST]:
        path.unlink(missing_ok=True)


def _lacks(numbers: Mapping[str, Any], wanted: Wanted) -> str:
    """Why there cannot be a picture; empty if there can."""
    if not numbers["mesh"]:
        return f"the backend {numbers['backend']!r} has no bodies to draw"
    if wanted.kind == "edges" and not wanted.edges:
        return "the last state has no contact edges, or too few nodes in contact to find them"
    return ""


def _draw(
    directory: Path, numbers: Mapping[str, Any], wanted: Sequence[Wanted]
) -> dict[str, dict[str, Any]]:
    """Caption and size of each picture, or why there is none."""
    if not wanted:
        return {}
    result = load_result(directory)
    reports = {
        each.file: _draw_status(directory, numbers, result, each)
        for each in wanted
        if each.kind == "status"
    }
    files = [each.file for each in wanted if each.kind != "status"]
    if not any((directory / FIELDS).glob("*.pvd")):
        reason = (
            "the run wrote no fields: 'fields' in the table [output] of the case says which states "
            'to write; "extremes" suits pictures'
        )
        return {**reports, **{file: {"reason": reason} for file in files}}
    return {**reports, **draw_in_child("pictures", directory, files)}


def _draw_status(
    directory: Path, numbers: Mapping[str, Any], result: Result, wanted: Wanted
) -> dict[str, Any]:
    figure, caption = draw_status(numbers, result, wanted.contacts, wanted.states)
    width, height = save_png(figure, directory / FOLDER / wanted.file)
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
    (directory / FOLDER / LIST).write_text(text + "\n", encoding="utf-8")
