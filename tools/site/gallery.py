# SPDX-License-Identifier: LGPL-3.0-or-later
"""The gallery of the site: demos that take seconds are run, and their figures shown.

Usage: gallery.py DEMO FOLDER      writes DEMO.txt and its figures into FOLDER
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
DEMOS = ROOT / "demos"
SHOWN = ("hertz", "ellipse", "wedge")
# Demos that take longer, with pictures that `tools/gallery_pictures.py` has stored.
STORED = {
    "dovetail": "A blade root in a dovetail slot under a cyclic pull",
    "firtree": "A firtree with three pairs of lobes",
    "sector": "One of 36 sectors of a disc that spins",
    "submodel": "A fine flank that a coarse run of the dovetail drives",
}
HEAD = """# Gallery

Demos that were run when this page was made. Each ends with computed against expected values; one
that is off stops the making of this site. The folder `demos` of a checkout has more.
"""


def run(name: str, folder: Path) -> None:
    """Run one demo in this process; a value that is off ends it with the demo's own status."""
    import fretfe

    script = DEMOS / f"{name}.py"
    names: dict[str, Any] = {"__name__": "__main__", "__file__": str(script)}
    printed = io.StringIO()
    sys.path.insert(0, str(DEMOS))
    try:
        with contextlib.redirect_stdout(printed):
            exec(compile(script.read_text("utf-8"), str(script), "exec"), names)
    except SystemExit as ended:
        if ended.code:
            sys.exit(f"{script} is off:\n{printed.getvalue()}")
    (folder / f"{name}.txt").write_text(printed.getvalue().strip("\n") + "\n")
    for figure in ("tractions", "factors"):
        draw = getattr(fretfe, f"plot_{figure}")
        draw(names["result"])[0].figure.savefig(folder / f"{name}_{figure}.png", dpi=110)


def page(name: str, folder: Path) -> str:
    """The section of a demo."""
    documentation, _, code = (DEMOS / f"{name}.py").read_text("utf-8").partition('"""\n\n')
    title, _, text = documentation.partition('"""')[2].partition("\n\n")
    text = text.partition("Run it with")[0]
    paragraphs = [
        f"```text\n{each}\n```" if each.startswith("    ") else each
        for each in text.strip("\n").split("\n\n")
    ]
    output = (folder / f"{name}.txt").read_text()
    case = (DEMOS / f"{name}.toml").read_text("utf-8")
    parts = [f"## {title.rstrip('.')}\n", *(f"{each}\n" for each in paragraphs)]
    parts += [f"![Pressure and shear at the load extremes](gallery/{name}_tractions.png)\n"]
    parts += [f"![K_N and K_T of both edges over time](gallery/{name}_factors.png)\n"]
    parts += [f"```text\n{output}```\n", f"`demos/{name}.toml`:\n", f"```toml\n{case}```\n"]
    parts += [f"`demos/{name}.py`:\n", f"```python\n{code.lstrip()}```\n"]
    return "\n".join(parts)


def digest() -> str:
    """Changes with everything that the demos depend on."""
    found = hashlib.sha256(Path(__file__).read_bytes())
    for folder in ("demos", "fretfe", "meshes"):
        for file in sorted((ROOT / folder).rglob("*")):
            if file.is_file() and "__pycache__" not in file.parts:
                found.update(file.read_bytes())
    return found.hexdigest()


def draw(folder: Path) -> None:
    """Run the demos, two at a time, unless nothing has changed since the last time."""
    stamp = folder / "digest"
    now = digest()
    if stamp.exists() and stamp.read_text() == now:
        return
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)

    def start(name: str) -> None:
        subprocess.run([sys.executable, __file__, name, folder], check=True)

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(start, SHOWN))
    stamp.write_text(now)


def write(source: Path, cache: Path) -> None:
    """Write the page and its figures."""
    draw(cache)
    shutil.copytree(cache, source / "gallery")
    pages = [page(name, cache) for name in SHOWN]
    stored = ["## Larger demos\n", "Von Mises stress at the load extremes, from runs before.\n"]
    for name, title in STORED.items():
        stored += [f"{title} (`demos/{name}.py`):\n", f"![{title}](images/gallery_{name}.png)\n"]
    (source / "gallery.md").write_text("\n".join([HEAD, *stored, *pages]))


if __name__ == "__main__":
    run(sys.argv[1], Path(sys.argv[2]))
