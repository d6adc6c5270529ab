# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables and files of materials that are damaged or hostile."""

from __future__ import annotations

from collections.abc import Iterator

from faults.changed import file_faults, with_file
from faults.fault import HALFPLANE, Fault
from faults.originals import (
    MATERIAL,
    between_case,
    csv_case,
    factors_case,
    material_case,
    points_case,
    shape_case,
    strain_case,
)


def faults() -> Iterator[Fault]:
    """All of them, and the files as they should be."""
    yield from _load_tables()
    yield from _tables_between()
    yield from _point_tables()
    yield from _shape_tables()
    yield from _factor_tables()
    yield from _strain_tables()
    yield from _materials()
    yield from _traction_tables()


def _load_tables() -> Iterator[Fault]:
    file, text = "loads.csv", csv_case()
    contents: dict[str, str | bytes] = {
        "decimal commas": "t,q\n0,0\n0,5,1,5\n1,0,20,5\n",
        "longer rows": "t,q\n0,0\n1,20,7\n",
        "shorter rows": "t,q\n0,0\n1\n",
        "one column": "t\n0\n1\n",
        "names twice": "t,q,q\n0,0,0\n1,1,1\n",
        "nan": "t,q\n0,0\n1,nan\n",
        "inf": "t,q\n0,0\n1,1e999\n",
        "huge": "t,q\n0,0\n1,1e300\n",
        "back in time": "t,q\n0,0\n2,1\n1,2\n",
        "same time": "t,q\n0,0\n1,1\n1,2\n",
        "formula": "t,q\n0,0\n1,=1+1\n",
        "quote": 't,q\n0,0\n1,"2\n',
        "NUL": b"t,q\n0,0\n1,2\0\n",
        "latin 1": "t,q\n0,0\n1,2 §\n".encode("latin-1"),
        "UTF-16": "t,q\n0,0\n1,2\n".encode("utf-16"),
        "long field": "t,q\n0,0\n1," + "9" * 200_000 + "\n",
        "underscores": "t,q\n0,0\n1,1_000\n",
        "Arabic digits": "t,q\n0,0\n1,٣\n",
        "hex": "t,q\n0,0\n1,0x10\n",
        "Fortran": "t,q\n0,0\n1,1D3\n",
        "header alone": "t,q\n",
        "mixed separators": "t;q\n0;0\n1,5;2.5\n",
        "thousands": "t;q\n0;0\n1;1.000,5\n",
    }
    yield from file_faults(file, text, contents, 24, command=HALFPLANE)


def _tables_between() -> Iterator[Fault]:
    """Gaps and coefficients of friction along the surface, as the numbers in a column."""
    for column, case in (
        ("gap", {"gap": "gap.csv"}),
        ("friction", {"friction": {"csv": "friction.csv"}}),
    ):
        contents = {
            "empty": "",
            "header alone": f"arc,{column}\n",
            "no column": "arc,value\n-3,0\n3,0\n",
            "no places": f"{column}\n0\n0\n",
            "two kinds of places": f"arc,x,y,{column}\n-3,0,0,0\n3,0,0,0\n",
            "x alone": f"x,{column}\n-3,0\n3,0\n",
            "of solids": f"x,y,z,{column}\n-3,0,0,0\n3,0,0,0\n",
            "half of the surface": f"arc,{column}\n0,0.1\n3,0.1\n",
            "far away": f"x,y,{column}\n70,0,0.1\n73,0,0.1\n",
            "one point": f"x,y,{column}\n0,0,0.1\n",
            "backwards": f"arc,{column}\n3,0.1\n-3,0.1\n",
            "negative": f"arc,{column}\n-3,-0.1\n3,-0.1\n",
            "nan": f"arc,{column}\n-3,nan\n3,0\n",
            "huge": f"arc,{column}\n-3,1e300\n3,0\n",
        }
        yield from file_faults(f"{column}.csv", between_case(**case), contents, 12)


def _point_tables() -> Iterator[Fault]:
    file, text = "points.csv", points_case()
    square = "x,y,T\n-30,-40,1\n30,-40,1\n-30,40,1\n30,40,{}\n"
    contents = {
        "empty": "",
        "header alone": "x,y,T\n",
        "one point": "x,y,T\n0,0,20\n",
        "no column T": "x,y,t\n0,0,20\n",
        "no column y": "x,T\n0,20\n",
        "nan": square.format("nan"),
        "huge": square.format("1e300"),
        "below absolute zero": square.format("-274"),
        "a point twice": square.format("1\n30,40,2"),
        "a point nearly twice": square.format("1\n30,40.0000000000001,2"),
        "elsewhere": square.replace("30", "300").replace("-300", "200").format("1"),
        "on a line through the middle of bodies": "x,y,T\n-1,0,1\n0,0,1\n1,0,1\n",
    }
    yield from file_faults(file, text, contents)


def _materials() -> Iterator[Fault]:
    file, text = "own.toml", material_case()
    contents = {
        "empty": "",
        "no source": MATERIAL.replace("source", "title"),
        "no units": MATERIAL.replace("units", "title"),
        "units of nothing": MATERIAL.replace("GPa", ""),
        "units that are not known": MATERIAL.replace("kg/m^3", "stone"),
        "nan": MATERIAL.replace("0.3", "nan"),
        "huge": MATERIAL.replace("7850.0", "1e300"),
        "rubber": MATERIAL.replace("0.3", "0.5"),
        "falling": MATERIAL.replace("[0, 100]", "[100, 0]"),
        "frozen": MATERIAL.replace("[0, 100]", "[-280, 100]"),
        "deep": MATERIAL + "elastic = " + "[" * 20000 + "]" * 20000,
        "a case": text,
        "long": MATERIAL + "#" * 2_000_000,
        "itself": MATERIAL + 'material = "own.toml"\n',
    }
    yield from file_faults(file, text, contents, 24, MATERIAL)


def _strain_tables() -> Iterator[Fault]:
    file, text = "strain.csv", strain_case()
    square = "x,y,exx,eyy,ezz,exy\n-30,-40,0,0,0,0\n30,-40,0,0,0,0\n-30,40,0,0,0,0\n30,40,{},0,0\n"
    contents = {
        "header alone": "x,y,exx,eyy,ezz,exy\n",
        "no column ezz": square.replace("ezz", "szz").format("0,0"),
        "shear angle": square.replace("exy", "gxy").format("0,0"),
        "a column twice": square.replace("eyy", "exx").format("0,0"),
        "nan": square.format("nan,0"),
        "huge": square.format("1e300,0"),
        "missing": square.format("1"),
        "a point twice": square.format("0,0,0,0\n30,40,0,0"),
        "elsewhere": square.replace("30", "1").format("0,0"),
        "metres": square.replace("30", ".03").replace("40", ".04").format("0,0"),
    }
    yield from file_faults(file, text, contents, content=square.format("1e-4,0"))


def _shape_tables() -> Iterator[Fault]:
    file, text = "shape.csv", shape_case()
    square = "x,y,ux,uy\n-30,-40,1,0\n30,-40,1,0\n-30,40,1,0\n30,40,{}\n"
    contents = {
        "header alone": "# x\nx,y,ux,uy\n",
        "comments alone": "# x,y,ux,uy\n#1,1,1,1\n",
        "no column uy": "x,y,ux,v\n0,0,20,1\n1,1,1,1\n",
        "nan": square.format("nan,0"),
        "huge": square.format("1e300,0"),
        "missing": square.format("1"),
        "a point twice": square.format("1,0\n30,40,2,0"),
        "elsewhere": square.replace("30", "1").format("1,0"),
        "metres": square.replace("30", ".03").replace("40", ".04").format("1,0"),
        "at rest": square.replace("1,0", "0,0").format("0,0"),
        "on another line": "x,y,ux,uy\n0,-40,1,1\n0,40,1,1\n",
    }
    yield from file_faults(file, text, contents)


def _factor_tables() -> Iterator[Fault]:
    """Tractions that vary over their boundary."""
    file, text = "factors.csv", factors_case()
    line = "x,y,value\n12,0,1\n12,-12,{}\n"
    contents = {
        "empty": "",
        "header alone": "x,y,value\n",
        "one point": "x,y,value\n12,0,1\n",
        "no column value": line.replace("value", "p").format("2"),
        "a column twice": line.replace("y", "value").format("2"),
        "nan": line.format("nan"),
        "inf": line.format("inf"),
        "huge": line.format("1e200"),
        "missing": line.format(""),
        "a point twice": line.format("2\n12,-12,3"),
        "a point nearly twice": line.format("2\n12,-12.0000000000001,3"),
        "a half": line.replace("-12", "-6").format("2"),
        "metres": line.replace("12", ".012").format("2"),
    }
    yield from file_faults(file, text, contents, content=line.format("2"))


def _traction_tables() -> Iterator[Fault]:
    file = "tractions.csv"
    command = ("edges", file, "--friction", "0.3", "--json")
    contents = {
        "no pressure": "x,p\n0,0\n1,0\n2,0\n",
        "negative": "x,p\n0,-1\n1,-2\n2,-1\n",
        "one row": "x,p\n0,1\n",
        "back": "x,p\n0,1\n-1,1\n",
        "longer": "x,p\n0,1,1,1\n1,1,1,1\n",
        "overflow": "x,p\n0,1e308\n1,1e308\n2,1e308\n3,0\n",
        "far": "x,p\n1e300,1\n1.1e300,2\n1.2e300,1\n",
        "tiny": "".join(["x,p\n", *(f"{i}e-320,{i % 5}\n" for i in range(1, 20))]),
    }
    yield from file_faults(file, "", contents, 24, command=command)
    for words in (("--friction", "nan"), ("--friction", "-1"), ("--friction", "0"), ("--x", "")):
        prepare = with_file(file, text="")
        yield Fault(f"{file} {words}", ("edges", file, *words), prepare, True)
