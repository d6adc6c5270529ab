# SPDX-License-Identifier: LGPL-3.0-or-later
"""The verification book of the site: what `fretfe verify` found when the site was made.

Usage: book.py FOLDER      writes verify.json, unless nothing has changed since the last time
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import gallery

from fretfe.case import case_text
from fretfe.quality.comparison import Benchmark
from fretfe.quality.verification import families
from fretfe.report.theme import BLUE, GREY, MARKERS, VERMILLION, make_figure

HEAD = """# Verification book

After this page you can see how each benchmark is posed, what is known of it, and what was computed.

The numbers are those of `fretfe verify` when these pages were made, with error bars where a number
has one. In the figures differences are over their tolerance: all must be between the lines.

    fretfe verify
"""
COLOURS = {"halfplane": BLUE, "fem": VERMILLION}
Rows = Sequence[Mapping[str, Any]]


def numbers(folder: Path) -> list[dict[str, Any]]:
    """The comparisons, computed unless they are there for this very code."""
    path, now = folder / "verify.json", gallery.digest()
    known = json.loads(path.read_text()) if path.exists() else {}
    if known.get("digest") != now:
        done = subprocess.run(
            [sys.executable, "-m", "fretfe", "verify", "--json"],
            stdout=subprocess.PIPE, text=True, check=True,
        )  # fmt: skip
        known = {**json.loads(done.stdout), "digest": now}
        folder.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(known))
    found: list[dict[str, Any]] = known["rows"]
    return found


def section(problem: str, family: Sequence[Benchmark], rows: Rows, picture: str) -> Iterator[str]:
    """Problem, source, known and computed numbers, and the case of one of them."""
    title, _, text = problem.partition("\n")
    yield f"## {_plain(title.rstrip('.'))}\n"
    if text.strip():
        yield f"{_plain(text.strip())}\n"
    yield f"Source: {_plain(family[0].source)}.\n"
    yield "| benchmark | quantity | known | backend | computed | difference | tolerance |"
    yield "|---|---|---|---|---|---|---|"
    for row in rows:
        name = row["benchmark"].removeprefix(f"{family[0].name}, ")
        values = [f"{row[key]:.5g}" for key in ("reference", "computed")]
        if row["spread"] is not None:
            values[1] += f" ± {row['spread']:.1g}"
        off, most = (f"{row[key]:.1e}" for key in ("difference", "tolerance"))
        cells = [name, row["quantity"], values[0], row["backend"], values[1], off, most]
        yield f"| {' | '.join(map(_plain, cells))} |"
    yield f"\n![Differences over their tolerances]({picture})\n"
    yield f"The case of *{_plain(family[0].name)}*:\n\n```toml\n{case_text(family[0].case)}```\n"


def _plain(text: str) -> str:
    return re.sub(r"([*_|<])", r"\\\1", text)


def draw(path: Path, rows: Rows) -> None:
    """Differences over their tolerances."""
    names = list(dict.fromkeys(f"{each['benchmark']}: {each['quantity']}" for each in rows))

    def figure(drawn: Any) -> None:
        axes = drawn.subplots()
        for (backend, colour), mark in zip(COLOURS.items(), MARKERS, strict=False):
            own = [each for each in rows if each["backend"] == backend]
            places = [names.index(f"{each['benchmark']}: {each['quantity']}") for each in own]
            shares = [each["difference"] / each["tolerance"] for each in own]
            axes.plot(shares, places, mark, color=colour, ms=4, label=backend)
        for limit in (-1, 0, 1):
            axes.axvline(limit, color=GREY, lw=0.8, ls=":" if limit else "-")
        axes.set_yticks(range(len(names)), names)
        axes.set_ylim(len(names) - 0.5, -0.5)
        axes.set_xlabel("difference over tolerance")
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)

    make_figure(7.4, 0.9 + 0.16 * len(names), figure).savefig(path)


def write(source: Path, cache: Path) -> None:
    """Write the page and its figures."""
    rows = numbers(cache)
    (source / "book").mkdir()
    lines = [HEAD]
    for place, (problem, family) in enumerate(families()):
        names = {each.name for each in family}
        own = [each for each in rows if each["benchmark"] in names and each["tolerance"]]
        picture = f"book/{place + 1}.svg"
        draw(source / picture, own)
        lines += section(problem, family, own, picture)
    (source / "book.md").write_text("\n".join(lines))
