# SPDX-License-Identifier: LGPL-3.0-or-later
"""The pictures of a results folder: `pictures/*.png`, and `pictures/pictures.json` that lists them.

Stress is drawn by another process, which may crash where OpenGL does not work: pictures that cannot
be made are listed with the reason.
"""

from __future__ import annotations

import base64
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures import wait as waited_for
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from fretfe.environment import idle_cores, without_launcher
from fretfe.errors import OutputError
from fretfe.faults import guarded, note_fault
from fretfe.files import replace_text, require_file, stranger_in, writing
from fretfe.report.pictures.looks import Wanted, plan_pictures
from fretfe.report.pictures.mesh import draw_status
from fretfe.report.pictures.panels import save_png
from fretfe.report.pictures.surfaces import draw_surface
from fretfe.report.source import folder_of
from fretfe.results.field_files import FIELDS
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.run_folder import require_stored
from fretfe.results.writer import PICTURE_LIST, PICTURES, remove_pictures

NO_FIELDS = (
    f"there is no {FIELDS}: 'fields' in the table [output] of the case says which states a run "
    'writes; "extremes" suits pictures'
)

# Errors of reading a list that is not as it was written.
DAMAGED = (OSError, AttributeError, KeyError, TypeError, ValueError, RecursionError)
# Kinds that need fields and are drawn by another process.
BY_CHILD = ("bodies", "edges")
# Seconds for all pictures of a call.
TIMEOUT = 600.0
# Seconds between words to those who wait for pictures.
EVERY = 3.0
CRASHES = (signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS, signal.SIGILL)
NO_PYVISTA = (
    "PyVista is not installed; `pip install pyvista` installs it, on Debian apt install "
    "python3-pyvista"
)
NO_OPENGL = (
    "the process that draws ended with {}, as it does where OpenGL does not work without a "
    "display. On Debian and Ubuntu install libegl1 and libgl1-mesa-dri (VTK 9.4 and later), or "
    "xvfb and xauth"
)
NOT_IMPORTED = (
    "PyVista cannot be imported ({}). On Debian and Ubuntu VTK needs libgl1 and libxrender1"
)


def make_pictures(
    directory: Path,
    meanwhile: Callable[[Result], None] = lambda _: None,
    say: Callable[[str], None] = lambda _: None,
) -> None:
    """Draw what a run has computed, as far as this machine can.

    Args:
        directory: results folder.
        meanwhile: other work with the results, done while other processes draw if cores are idle.
        say: how many pictures there are, while those who wait have nothing else to see.

    Raises:
        OutputError: if the results cannot be read or the folder cannot be written to, or is a
            link.
    """
    run = load_result(directory)
    # Pictures of that folder would be removed, and others written there.
    if (found := stranger_in(directory / PICTURES)) is not None:
        kind = "folder" if found.name == PICTURES else "file"
        raise OutputError(f"{found}: expected a {kind}, found a link or a pipe")
    remove_pictures(directory)
    wanted = plan_pictures(run)
    reports = {each.file: {"reason": reason} for each in wanted if (reason := _lacks(run, each))}
    with writing(directory / PICTURES, "pictures"):
        (directory / PICTURES).mkdir(exist_ok=True)
        missing = [each for each in wanted if each.file not in reports]
        reports |= _draw(run, missing, meanwhile, say)
        _write_list(directory, wanted, reports)


def _lacks(run: Result, wanted: Wanted) -> str:
    """The reason why there cannot be a picture; empty if there can."""
    if not run.bodies:
        return f"the backend {run.backend!r} has no bodies to draw"
    if wanted.kind == "edges" and not wanted.edges:
        return "the load extremes have no contact edges, or too few nodes in contact to find them"
    return ""


def _draw(
    run: Result,
    wanted: Sequence[Wanted],
    meanwhile: Callable[[Result], None],
    say: Callable[[str], None],
) -> dict[str, dict[str, Any]]:
    """Caption and size of each picture, or the reason why there is none."""
    files = [each.file for each in wanted if each.kind in BY_CHILD]
    reports: dict[str, dict[str, Any]] = {}
    if not (folder_of(run) / FIELDS).exists():
        reports |= {file: {"reason": NO_FIELDS} for file in files}
        files = []
    idle = idle_cores()
    if not idle:
        meanwhile(run)
    # The threads only wait for their processes.
    with ThreadPoolExecutor(max(idle, 1)) as waiting:
        shares = [files[first :: max(idle, 1)] for first in range(min(len(files), max(idle, 1)))]
        drawn = [waiting.submit(draw_in_child, folder_of(run), share) for share in shares]
        if idle:
            meanwhile(run)
        for each in wanted:
            if each.kind not in BY_CHILD:
                reports[each.file] = guarded(
                    f"picture {each.file}",
                    partial(_draw_contacts, run, each),
                    lambda fault: {"reason": fault.reason},
                )
        while waited_for(drawn, EVERY).not_done:
            there = sum((folder_of(run) / PICTURES / each.file).exists() for each in wanted)
            say(f"picture {min(there + 1, len(wanted))} of {len(wanted)}")
        for share in drawn:
            reports |= {file: _checked(file, report) for file, report in share.result().items()}
    return reports


def _checked(file: str, report: dict[str, Any]) -> dict[str, Any]:
    """The report of another process on a picture; where fretfe failed there, that is noted."""
    if "error" not in report:
        return report
    if reason := _import_reason(report["error"]):
        return {"reason": reason}
    fault = note_fault(f"picture {file}", report["error"], report["trace"])
    return {"reason": fault.reason}


def _draw_contacts(run: Result, wanted: Wanted) -> dict[str, Any]:
    """Caption and size of a picture that needs no fields."""
    path = folder_of(run) / PICTURES / wanted.file
    if wanted.kind == "surface":
        figure, caption = draw_surface(run, wanted.contacts[0], wanted.states)
    else:
        figure, caption = draw_status(run, wanted.contacts, wanted.states)
    width, height = save_png(figure, path)
    return {"caption": caption, "width": width, "height": height}


def _write_list(
    directory: Path, wanted: Sequence[Wanted], reports: Mapping[str, Mapping[str, Any]]
) -> None:
    pictures: list[dict[str, Any]] = []
    missing: list[dict[str, Any]] = []
    for each in wanted:
        report = dict(reports[each.file])
        if "reason" in report:
            missing.append({"title": each.title, "reason": report.pop("reason")})
        if report:
            pictures.append({"file": each.file, "title": each.title, **report})
    lists = {"pictures": pictures, "missing": missing}
    text = json.dumps(lists, indent=1, ensure_ascii=False)
    replace_text(directory / PICTURES / PICTURE_LIST, text + "\n")


def lacks_pictures(directory: Path) -> bool:
    """True if a results folder has no list of pictures, or not all that are listed.

    A list that cannot be read is for `read_pictures` to complain about.
    """
    folder = directory / PICTURES
    if not (folder / PICTURE_LIST).exists():
        return True
    require_stored(folder / PICTURE_LIST)
    try:
        listed = json.loads((folder / PICTURE_LIST).read_text(encoding="utf-8"))
        files = [each["file"] for each in listed["pictures"]]
        return not all((folder / Path(file).name).exists() for file in files)
    except DAMAGED:
        return False


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
    require_stored(path)
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
    except DAMAGED as error:
        found = f"no key {error}" if isinstance(error, KeyError) else str(error)
        raise OutputError(f"{path}: expected a list of pictures, found: {found}") from error
    return Pictures(shown, missing)


def _data_uri(path: Path) -> str:
    require_file(path, "a picture", OutputError)
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")


def draw_in_child(
    directory: Path, files: Sequence[str], timeout: float = TIMEOUT
) -> dict[str, dict[str, Any]]:
    """Let `fretfe.report.pictures.render` draw some pictures.

    Args:
        directory: results folder.
        files: what to draw.
        timeout: seconds.

    Returns:
        What was said about each file; `reason` if there is none.
    """
    reports: dict[str, dict[str, Any]] = {}
    reason = ""
    for launcher in _launchers():
        rest = [file for file in files if file not in reports]
        if rest:
            module = [sys.executable, "-P", "-m", "fretfe.report.pictures.render"]
            found, reason = _run([*launcher, *module, str(directory), *rest], timeout)
            reports |= found
    return {file: reports.get(file, {"reason": reason}) for file in files}


def _launchers() -> list[list[str]]:
    """As it is; then with a display of its own, if that can be had."""
    xvfb = shutil.which("xvfb-run")
    # Debian only recommends xauth together with xvfb, but xvfb-run does nothing without it.
    return [[], [xvfb, "-a"]] if xvfb and shutil.which("xauth") else [[]]


def _run(command: list[str], timeout: float) -> tuple[dict[str, dict[str, Any]], str]:
    """Reports of a process on each file, and the reason if it did not say more."""
    # A child must not take itself for a process of an MPI run. Its own session: a launcher and
    # all that it starts can be ended together.
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        env=without_launcher(os.environ),
        start_new_session=True,
    )
    try:
        output, messages = process.communicate(timeout=timeout)
        reason = _reason(process.returncode, messages)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        output, _ = process.communicate()
        reason = f"drawing took more than {timeout:g} s"
    return _reports(output), reason


def _reports(output: str) -> dict[str, dict[str, Any]]:
    """The lines of JSON in an output; a crash may cut the last one, libraries may add others."""
    reports = {}
    for line in output.splitlines():
        try:
            report = json.loads(line)
            reports[report.pop("file")] = report
        except (ValueError, AttributeError, KeyError, TypeError):
            continue
    return reports


def _reason(code: int, messages: str) -> str:
    """Reason why a process ended, in words."""
    # A shell between us and the process says 128 + n for signal n.
    number = -code if code < 0 else code - 128
    if number > 0:
        known = number in set(signal.Signals)
        name = signal.Signals(number).name if known else f"signal {number}"
        crashed = known and signal.Signals(number) in CRASHES
        return NO_OPENGL.format(name) if crashed else f"the process that draws ended with {name}"
    lines = [line for line in messages.splitlines() if line.strip()]
    last = lines[-1].strip() if lines else f"exit code {code}"
    return _import_reason(last) or last


def _import_reason(error: str) -> str:
    """Reason for a type and text of an error in words if a package is missing; empty otherwise."""
    if error.startswith("ModuleNotFoundError") and "'pyvista'" in error:
        return NO_PYVISTA
    return NOT_IMPORTED.format(error) if error.startswith(("ImportError", "ModuleNot")) else ""
