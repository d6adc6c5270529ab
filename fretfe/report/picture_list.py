# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of the bodies for the page, as `pictures/pictures.json` lists them."""

from __future__ import annotations

import base64
import json
from dataclasses import dataclass
from pathlib import Path

from fretfe.errors import OutputError
from fretfe.report.picture_plan import FOLDER, LIST


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
    folder = directory / FOLDER
    path = folder / LIST
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
