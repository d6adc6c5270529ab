# SPDX-License-Identifier: LGPL-3.0-or-later
"""Run the larger demos and store a picture of each for the gallery of the site.

Run from anywhere: .venv/bin/python tools/gallery_pictures.py [FOLDER] (minutes); runs that are
complete in the folder are not done again.
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import mkdtemp

from PIL import Image

import fretfe
from fretfe.errors import OutputError

ROOT = Path(__file__).parents[1]
IMAGES = ROOT / "docs" / "images"
NAMES = ("dovetail", "firtree", "sector", "submodel")
# As of demos/submodel.py.
COARSE = {"geometry.parameters.edge_size": 0.02, "output.fields": "all"}
# Pixels.
WIDTH = 900


def run(case: Path, folder: Path, changes: dict[str, object] | None = None) -> fretfe.Result:
    """The results of a case, from the folder if they are complete."""
    try:
        return fretfe.load_result(folder)
    except OutputError:
        return fretfe.run(fretfe.load_case(case, changes or {}), output=folder)


def solve(name: str, folder: Path) -> None:
    """Run a demo; of the sub-model the global run first."""
    case = ROOT / "demos" / f"{name}.toml"
    if name == "submodel":
        coarse = run(ROOT / "demos" / "dovetail.toml", folder / "global", COARSE)
        case = folder / "case" / "submodel.toml"
        if not case.exists():
            fretfe.write_submodel(coarse, "left", case.parent, radius=6.5, size=0.002)
    run(case, folder / name)


def main() -> None:
    """Store all pictures."""
    folder = Path(sys.argv[1] if sys.argv[1:] else mkdtemp())
    for name in NAMES:
        solve(name, folder)
        with Image.open(folder / name / "pictures" / "stress.png") as picture:
            size = WIDTH, round(WIDTH * picture.height / picture.width)
            small = picture.convert("RGB").resize(size)
        small.quantize(256, Image.Quantize.MAXCOVERAGE).save(
            IMAGES / f"gallery_{name}.png", optimize=True
        )


if __name__ == "__main__":
    main()
