# SPDX-License-Identifier: LGPL-3.0-or-later
"""Gmsh scripts of a pad with two bumps on one surface, on a flat block, and cases with them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from cases.pad_cases import BASE, HOLD, STEEL, TOP, wave

from fretfe.case import Case, parse_case

E_STAR = 210e3 / (2 * (1 - 0.3**2))
# Cylinders at -3 and 3.
RADIUS = 50.0
CYLINDERS = """
R = 50; c = 3; e = 0.9; h = 0.025; H = 16; W = 16; far = 3;
Point(1) = {-c, R, 0}; Point(2) = {c, R, 0};
Point(3) = {-2*c, R - Sqrt(R*R - c*c), 0, 0.5}; Point(4) = {-c - e, R - Sqrt(R*R - e*e), 0, h};
Point(5) = {-c + e, R - Sqrt(R*R - e*e), 0, h}; Point(6) = {0, R - Sqrt(R*R - c*c), 0, 0.5};
Point(7) = {c - e, R - Sqrt(R*R - e*e), 0, h}; Point(8) = {c + e, R - Sqrt(R*R - e*e), 0, h};
Point(9) = {2*c, R - Sqrt(R*R - c*c), 0, 0.5};
Circle(1) = {3, 1, 4}; Circle(2) = {4, 1, 5}; Circle(3) = {5, 1, 6};
Circle(4) = {6, 2, 7}; Circle(5) = {7, 2, 8}; Circle(6) = {8, 2, 9};
Physical Curve("upper_contact") = {1:6};
w = 2*c;
"""
# The wave C (x^2 - c^2)^2 / 2, whose patches at -c and c merge at P = pi C E* c^4 / 2.
SHALLOWNESS = 4e-3
MERGING = math.pi * SHALLOWNESS * E_STAR / 2
WAVES = """
c = 1; C = 4e-3; h = 0.02; w = 2.2; H = 80; W = 80; far = 12;
For i In {0:176}
  x = -w + i*w/88;
  Point(3 + i) = {x, C*(x*x - c*c)*(x*x - c*c)/2, 0, h};
EndFor
Spline(1) = {3:179};
Physical Curve("upper_contact") = {1};
"""
BODIES = """
a = newp;
Point(a) = {W, 4, 0, far}; Point(a + 1) = {W, H, 0, far}; Point(a + 2) = {-W, H, 0, far};
Point(a + 3) = {-W, 4, 0, far};
first = 3; last = a - 1; k = newl;
Line(k) = {last, a}; Line(k + 1) = {a, a + 1}; Line(k + 2) = {a + 1, a + 2};
Line(k + 3) = {a + 2, a + 3}; Line(k + 4) = {a + 3, first};
Curve Loop(1) = {1:k + 4}; Plane Surface(1) = {1};
b = newp; s = newl;
Point(b) = {-W, 0, 0, far}; Point(b + 1) = {-W, -W, 0, far}; Point(b + 2) = {W, -W, 0, far};
Point(b + 3) = {W, 0, 0, far};
"""
LOWER_CYLINDERS = """
Point(b + 4) = {2*c, 0, 0, 0.5}; Point(b + 5) = {c + e, 0, 0, h}; Point(b + 6) = {c - e, 0, 0, h};
Point(b + 7) = {0, 0, 0, 0.5}; Point(b + 8) = {-c + e, 0, 0, h}; Point(b + 9) = {-c - e, 0, 0, h};
Point(b + 10) = {-2*c, 0, 0, 0.5};
n = 10;
"""
LOWER_WAVES = """
Point(b + 4) = {w, 0, 0, h}; Point(b + 5) = {-w, 0, 0, h};
n = 5;
"""
NAMES = """
For i In {0:n - 1}
  Line(s + i) = {b + i, b + i + 1};
EndFor
Line(s + n) = {b + n, b};
Curve Loop(2) = {s:s + n}; Plane Surface(2) = {2};
Physical Surface("upper") = {1}; Physical Surface("lower") = {2};
Physical Curve("upper_top") = {k + 2};
Physical Curve("lower_contact") = {s + 4:s + n - 1}; Physical Curve("lower_bottom") = {s + 1};
"""
SCRIPTS = {
    "cylinders": CYLINDERS + BODIES + LOWER_CYLINDERS + NAMES,
    "waves": WAVES + BODIES + LOWER_WAVES + NAMES,
}


def case_of(folder: Path, kind: str, loads: dict[str, Any], friction: float = 0.5) -> Case:
    """A case of a pad of a kind, whose script is written into a folder."""
    (folder / f"{kind}.geo").write_text(SCRIPTS[kind])
    contact = {"surface1": "upper_contact", "surface2": "lower_contact", "friction": friction}
    tables: dict[str, Any] = {
        "geometry": {"file": f"{kind}.geo"},
        "bodies": {"upper": STEEL, "lower": STEEL},
        "contacts": {"pad": {**contact, "friction_from": 1.0}},
        "supports": BASE,
        "loads": loads,
    }
    return parse_case(tables, folder / "case.toml", trust_geo=True)


def cylinders(folder: Path, normal: float, shear: float) -> Case:
    """Two cylinders pressed on without friction, then sheared to and fro."""
    press = {**TOP, "direction": "y", "history": [{"ramp": -normal, "until": 1, "steps": 3}]}
    to_and_fro = {**TOP, "direction": "x", "history": [HOLD, wave(shear, steps=12)]}
    return case_of(folder, "cylinders", {"press": press, "shear": to_and_fro})


def waves(folder: Path, forces: list[float]) -> Case:
    """Waves pressed on by one force after the other, in a step each, without friction."""
    history = [{"ramp": -force, "until": n, "steps": 1} for n, force in enumerate(forces, 1)]
    press = {**TOP, "direction": "y", "history": history}
    return case_of(folder, "waves", {"press": press}, friction=0.0)
