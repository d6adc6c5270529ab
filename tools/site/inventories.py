# SPDX-License-Identifier: LGPL-3.0-or-later
"""Inventories of other libraries: the few names that signatures of fretfe use.

Sphinx would download the whole inventory of each library; a build without a network has these.
"""

from __future__ import annotations

import zlib
from pathlib import Path

# By library: the address of its documents, and where each name stands there.
NAMES = {
    "python": (
        "https://docs.python.org/3/",
        {
            "collections.abc.Callable": "class library/collections.abc.html",
            "collections.abc.Iterator": "class library/collections.abc.html",
            "collections.abc.Mapping": "class library/collections.abc.html",
            "collections.abc.Sequence": "class library/collections.abc.html",
            "pathlib.Path": "class library/pathlib.html",
            "typing.Any": "data library/typing.html",
            "typing.Literal": "data library/typing.html",
            "typing.Protocol": "class library/typing.html",
            "KeyError": "exception library/exceptions.html",
            "ValueError": "exception library/exceptions.html",
        },
    ),
    "numpy": (
        "https://numpy.org/doc/stable/",
        {
            "numpy.ndarray": "class reference/generated/numpy.ndarray.html",
            "numpy.typing.ArrayLike": "data reference/typing.html",
            "numpy.typing.NDArray": "data reference/typing.html",
            "numpy.float64": "class reference/arrays.scalars.html",
            "numpy.int64": "class reference/arrays.scalars.html",
            "numpy.bool": "class reference/arrays.scalars.html",
        },
    ),
    "matplotlib": (
        "https://matplotlib.org/stable/",
        {"matplotlib.figure.Figure": "class api/figure_api.html"},
    ),
    "pandas": (
        "https://pandas.pydata.org/docs/",
        {"pandas.DataFrame": "class reference/api/pandas.DataFrame.html"},
    ),
    "xarray": (
        "https://docs.xarray.dev/en/stable/",
        {"xarray.Dataset": "class generated/xarray.Dataset.html"},
    ),
}


def write(folder: Path) -> dict[str, tuple[str, str]]:
    """Write the inventories; return what Sphinx calls `intersphinx_mapping`."""
    folder.mkdir(parents=True, exist_ok=True)
    mapping = {}
    for library, (address, names) in NAMES.items():
        file = folder / f"{library}.inv"
        lines = []
        for name, place in sorted(names.items()):
            kind, page = place.split()
            lines.append(f"{name} py:{kind} 1 {page}#$ -\n")
        head = f"# Sphinx inventory version 2\n# Project: {library}\n# Version: \n"
        head += "# The remainder of this file is compressed using zlib.\n"
        file.write_bytes(head.encode() + zlib.compress("".join(lines).encode()))
        mapping[library] = (address, str(file))
    return mapping
