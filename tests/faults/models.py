# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cases that are well formed but make no sense as mechanics."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import tomli_w
from cases.pad_cases import BASE, TOP, press, shear
from faults.fault import CHECK, FEM, HALFPLANE, Fault, text_fault
from faults.originals import PAD, SOLID

Tables = dict[str, Any]
SIDE = {"boundary": "lower_left", "fix": ["x"]}
BOTH = {"boundary": "lower_bottom", "fix": ["x", "y"]}


def loads(**more: Any) -> Tables:
    return {"loads": {"press": press(steps=1), "shear": shear(steps=4, cycles=1), **more}}


def pull(boundary: str, **options: Any) -> Tables:
    history = [{"ramp": 1.0, "until": 1.0, "steps": 1}]
    return {"type": "traction", "boundary": boundary, "direction": "normal", "history": history,
            **options}  # fmt: skip


def bodies(**values: Any) -> Tables:
    return {"bodies": {name: {**each, **values} for name, each in PAD["bodies"].items()}}


RAMP = [{"ramp": 1.0, "until": 1.0, "steps": 1}]
OVER = {"temperatures": [0, 100], "values": [210e3, 190e3]}
CUBIC = {"cubic": [250e3, 160e3, 130e3]}
WARM = {"expansion": 1e-5, "reference_temperature": 20.0}


def heat(constants: Tables | None = None, **keys: Any) -> Tables:
    """A temperature of bodies that expand, whose constants may be others."""
    load = {"type": "temperature", "history": RAMP, **keys}
    return {**bodies(**{**WARM, **(constants or {})}), **loads(heat=load)}


def peen(**keys: Any) -> Tables:
    layer = {"surfaces": ["lower_contact"], "depths": [0.0, 0.5], "values": [1e-4, 0.0]}
    return loads(peen={"type": "eigenstrain", "history": RAMP, **layer, **keys})


def push(**keys: Any) -> Tables:
    return {"type": "force", "boundary": "lower_right", "direction": "x", "history": RAMP, **keys}


def mode(values: list[list[float]], **keys: Any) -> Tables:
    shape = {"points": [[12, 0], [12, -12]], "values": values}
    return {"type": "shape", "boundary": "lower_right", "history": RAMP, **shape, **keys}


def only(**keys: Any) -> Tables:
    """Bodies with these keys alone."""
    return {"bodies": {name: keys for name in PAD["bodies"]}}


def crystal(elastic: Tables, orientation: Tables | None = None) -> Tables:
    return only(elastic=elastic, **({"orientation": orientation} if orientation else {}))


def fit(contact: str, overlap: float) -> Tables:
    history = [{"ramp": overlap, "until": 1.0, "steps": 1}]
    return loads(fit={"type": "interference", "contact": contact, "history": history})


def contact(**values: Any) -> Tables:
    return {"contacts": {"main": {**PAD["contacts"]["main"], **values}}}


def parameters(**values: float) -> Tables:
    own = PAD["geometry"]
    return {"geometry": {**own, "parameters": {**own["parameters"], **values}}}


# Tables in place of those of the pad; must they be refused?
MODELS: dict[str, tuple[Tables, bool | None]] = {
    "no supports": ({"supports": {}}, True),
    "support in x alone": ({"supports": {"base": {**BOTH, "fix": ["x"]}}}, True),
    "no loads": ({"loads": {}}, True),
    "pulled apart": ({"loads": {"press": press(-600.0, steps=1)}}, True),
    "shear alone": ({"loads": {"shear": shear(steps=4, cycles=1)}}, None),
    "sheared away": (loads(shear=shear(6000.0, steps=4, cycles=1)), True),
    "no friction": (contact(friction=0.0), True),
    "friction of 1e9": (contact(friction=1e9), None),
    "negative friction": (contact(friction=-0.1), True),
    "friction from later than the end": (contact(friction_from=99.0), True),
    "support on a contact surface": (
        {"supports": {**BASE, "held": {"boundary": "lower_contact", "fix": ["x"]}}}, True,
    ),
    "held on its other contact surface": (
        {"supports": {**BASE, "held": {"boundary": "upper_contact", "fix": ["y"]}}}, True,
    ),
    "traction on a contact surface": (loads(pull=pull("upper_contact")), None),
    "displacement of a contact surface": (
        loads(pull=pull("upper_contact", type="displacement", direction="x")), True,
    ),
    "platen on a contact surface": (loads(more={**press(steps=1), "boundary": "upper_contact"}),
                                    True),
    "load on nothing": (loads(pull=pull("nothing")), True),
    "load on a body": (loads(pull=pull("upper")), True),
    "support of nothing": ({"supports": {"base": {**BOTH, "boundary": "nothing"}}}, True),
    "held twice": ({"supports": {**BASE, "again": BOTH}}, None),
    "platen that is held": ({"supports": {**BASE, "top": {**BOTH, "boundary": "upper_top"}}}, True),
    "contact with itself": (contact(surface1="lower_contact"), True),
    "contact with the other side": (contact(surface2="lower_bottom"), True),
    "contact of one body": (contact(surface2="upper_top"), True),
    "contact with nothing": (contact(surface2="nothing"), True),
    "two contacts on the same surfaces": (
        {"contacts": {name: PAD["contacts"]["main"] for name in ("a", "b")}}, True,
    ),
    "a body that is not there": (
        {"bodies": {**PAD["bodies"], "third": PAD["bodies"]["upper"]}}, True,
    ),
    "a body that is missing": (
        {"bodies": {"upper": PAD["bodies"]["upper"], "other": PAD["bodies"]["upper"]}}, True,
    ),
    "soft as nothing": (bodies(young=1e-25), None),
    "rigid": (bodies(young=1e25), None),
    "one rigid, one soft": (
        {"bodies": {"upper": {"young": 1e-20, "poisson": 0.3},
                    "lower": {"young": 1e20, "poisson": 0.3}}}, None,
    ),
    "nearly incompressible": (bodies(poisson=0.499999999), None),
    "auxetic": (bodies(poisson=-0.999999999), None),
    **{
        f"unlike bodies at the length {length:g}": (
            {"edges": {"reference_length": length},
             "bodies": {"upper": {"young": 1e5, "poisson": 0.2}, "lower": PAD["bodies"]["lower"]}},
            None,
        )
        for length in (1e-29, 1e29)
    },
    "length of nothing": ({"edges": {"reference_length": 0.0}}, True),
    "thickness of 1e-20": ({"model": {"thickness": 1e-20, "degree": 1}}, None),
    "thickness of 1e20": ({"model": {"thickness": 1e20, "degree": 1}}, None),
    "force of 1e15": ({"loads": {"press": press(1e15, steps=1)}}, None),
    "force of 1e-15": ({"loads": {"press": press(1e-15, steps=1)}}, None),
    "force of 1e-290": ({"loads": {"press": press(1e-290, steps=1)}}, None),
    "no force": ({"loads": {"press": press(0.0, steps=1)}}, None),
    "density without rotation": (bodies(density=1e-9), None),
    "rotation without density": (
        loads(spin={"type": "rotation", "centre": [0, 0],
                    "history": [{"ramp": 1.0, "until": 1.0, "steps": 1}]}), True,
    ),
    "rotation of 1e20": (
        {**bodies(density=1.0),
         **loads(spin={"type": "rotation", "centre": [0, 0],
                       "history": [{"ramp": 1e20, "until": 1.0, "steps": 1}]})}, None,
    ),
    "heat of bodies that do not expand": (loads(heat=heat(value=90.0)["loads"]["heat"]), True),
    "heat below absolute zero": (heat(value=-274.0), True),
    "heat below absolute zero by its history": (
        heat(value=0.0, history=[{"ramp": 20.0, "until": 1.0, "steps": 1}]), True,
    ),
    "heat of nothing": (heat(value=90.0, bodies=["nothing"]), True),
    "heat of 1e20": (heat(value=1e20), None),
    "heat by an expansion of 1e20": (heat({"expansion": 1e20}, value=90.0), None),
    "heat of two values": (heat(value=90.0, points=[[0, 0], [1, 1]], values=[1, 2]), True),
    "heat at points elsewhere": (heat(points=[[50, 0], [60, 0]], values=[1, 2]), True),
    "heat at points in one place": (heat(points=[[5, 0], [5, 0]], values=[1, 2]), True),
    "heat at points a hair apart": (heat(points=[[5, 0], [5.0000001, 0]], values=[1, 2]), True),
    "heat at points 1e29 apart": (heat(points=[[-1e29, 0], [1e29, 0]], values=[1, 2]), None),
    "heat at points next to a line": (
        heat(points=[[-50, -50], [50, 50], [0, 0.01]], values=[1, 2, 3]), True,
    ),
    "heat at points of space": (heat(points=[[0, 0, 0], [1, 1, 1]], values=[1, 2]), True),
    "a layer below nothing": (peen(surfaces=["nothing"]), True),
    "constants over temperature": (bodies(young=OVER, temperature=50.0), False),
    "constants at no temperature": (bodies(young=OVER), True),
    "constants of another temperature": (bodies(young=OVER, temperature=150.0), True),
    "constants at nan": (bodies(young=OVER, temperature=float("nan")), True),
    "constants of temperatures that fall": (
        bodies(young={**OVER, "temperatures": [100, 0]}, temperature=50.0), True,
    ),
    "constants of one temperature twice": (
        bodies(young={**OVER, "temperatures": [50, 50]}, temperature=50.0), True,
    ),
    "constants below absolute zero": (
        bodies(young={**OVER, "temperatures": [-274, 100]}, temperature=50.0), True,
    ),
    "constants of more temperatures": (
        bodies(young={**OVER, "temperatures": [0, 50, 100]}, temperature=50.0), True,
    ),
    "constants of nan": (bodies(young={**OVER, "values": [1e5, float("nan")]}, temperature=50.0),
                         True),
    "constants that fall below 0": (bodies(young={**OVER, "values": [1e5, -9e5]},
                                           temperature=50.0), True),
    "constants in lists": (bodies(young={**OVER, "values": [[1e5], [1e5]]}, temperature=50.0),
                           True),
    "constants of text": (bodies(young={**OVER, "values": ["1", "2"]}, temperature=50.0), True),
    "a material": (only(material="steel"), False),
    "a material that is not there": (only(material="unobtainium"), True),
    "a material elsewhere": (only(material="../../../etc/passwd"), True),
    "a material in a device": (only(material="/dev/zero"), True),
    "a material in no file": (only(material="none.toml"), True),
    "a material of a table": (only(material={"young": 1.0}), True),
    "a material over temperature": (only(material="CrMo-steel"), True),
    "a material in furlongs": ({**only(material="steel"), "units": {"length": "furlong"}}, True),
    "a material in units that differ": ({**only(material="steel"), "units": {"stress": "GPa"}},
                                        True),
    "a crystal": (crystal(CUBIC), False),
    "a crystal that is not stable": (crystal({"cubic": [100.0, 200.0, 50.0]}), True),
    "a crystal that shears by itself": (crystal({"cubic": [250e3, 160e3, -1.0]}), True),
    "a crystal of nan": (crystal({"cubic": [float("nan"), 160e3, 130e3]}), True),
    "a crystal of 1e30": (crystal({"cubic": [1e30, 1e29, 1e29]}), None),
    "a crystal of two constants": (crystal({"cubic": [250e3, 160e3]}), True),
    "a crystal of 20 constants": (crystal({"constants": [1.0] * 20}), True),
    "a crystal of 21 ones": (crystal({"constants": [1.0] * 21}), True),
    "a crystal in two ways": (crystal({**CUBIC, "constants": [1.0] * 21}), True),
    "a crystal of nothing": (crystal({}), True),
    "a crystal of impossible contraction": (
        crystal({"orthotropic": {"young": [1.0, 1.0, 1.0], "poisson": [2.0, 2.0, 2.0],
                                 "shear": [1.0, 1.0, 1.0]}}), True,
    ),
    "a crystal with a modulus": (bodies(elastic=CUBIC), True),
    "crystal axes that are not at right angles": (
        crystal(CUBIC, {"x": [1, 0, 0], "y": [1, 1, 0]}), True,
    ),
    "crystal axes that are parallel": (crystal(CUBIC, {"x": [1, 0, 0], "y": [2, 0, 0]}), True),
    "one crystal axis": (crystal(CUBIC, {"x": [1, 0, 0]}), True),
    "three crystal axes": (crystal(CUBIC, {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1]}), True),
    "a crystal axis of no length": (crystal(CUBIC, {"x": [0, 0, 0], "y": [0, 1, 0]}), True),
    "a crystal axis of nan": (crystal(CUBIC, {"x": [float("nan"), 0, 0], "y": [0, 1, 0]}), True),
    "a mirrored crystal": (crystal(CUBIC, {"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, -1]]}), True),
    "a stretched crystal": (crystal(CUBIC, {"matrix": [[2, 0, 0], [0, 1, 0], [0, 0, 1]]}), True),
    "a crystal turned by 4 numbers": (crystal(CUBIC, {"matrix": [[1, 0], [0, 1]]}), True),
    "a crystal turned by nan": (crystal(CUBIC, {"euler": [float("nan"), 0, 0]}), True),
    "a crystal turned by 1e30": (crystal(CUBIC, {"euler": [1e30, 0, 0]}), None),
    "a crystal turned twice": (crystal(CUBIC, {"euler": [0, 0, 0], "x": [1, 0, 0],
                                               "y": [0, 1, 0]}), True),
    "a crystal that couples u_z": (crystal(CUBIC, {"euler": [10, 20, 30]}), True),
    "a layer and a file": (peen(file="strain.csv"), True),
    "strains from a file that is not there": (
        loads(weld={"type": "eigenstrain", "history": RAMP, "file": "no.csv"}), True,
    ),
    "strains from a folder": (
        loads(weld={"type": "eigenstrain", "history": RAMP, "file": ".."}), True,
    ),
    "a layer below a body": (peen(surfaces=["lower"]), True),
    "a layer of strain 1e20": (peen(values=[1e20, 0.0]), None),
    "a layer in the air": (peen(depths=[-1.0, 0.0]), True),
    "a layer 1e-20 deep": (peen(depths=[0.0, 1e-20]), None),
    "a layer deeper than the body": (peen(depths=[0.0, 1e20]), None),
    "a fit of nothing": (fit("nothing", 0.01), True),
    "a fit of 1e20": (fit("main", 1e20), None),
    "a fit by a gap": (fit("main", -1.0), None),
    "pressure at points elsewhere": (
        loads(pull=pull("lower_left", points=[[0, 0], [0, 1]], values=[1, 2])), True,
    ),
    "pressure by two kinds of points": (
        loads(pull=pull("lower_left", points=[[0, 0], [0, 1]], values=[1, 2], file="a.csv")), True,
    ),
    "pressure at one point twice": (
        loads(pull=pull("lower_right", points=[[12, 0], [12, -12], [12, -12.0000000000001]],
                        values=[1, 2, 9])), True,
    ),
    "pressure of nothing": (
        loads(pull=pull("lower_right", points=[[12, 0], [12, -12]], values=[0, 0])), False,
    ),
    "a force": (loads(push=push()), False),
    "a force on a part": (loads(push=push(centre=[12, -6], radius=3.0)), False),
    "a force on a part that is empty": (loads(push=push(centre=[12, 6], radius=3.0)), True),
    "a force on a part between nodes": (loads(push=push(centre=[12, -5.9], radius=1e-6)), True),
    "a force on a part within an element": (
        loads(push=push(centre=[12, -12], radius=1e-6)), True,
    ),
    "a force on a part of no radius": (loads(push=push(centre=[12, -6], radius=0.0)), True),
    "a force on a part of nan": (loads(push=push(centre=[12, -6], radius=float("nan"))), True),
    "a force on a part in space": (loads(push=push(centre=[12, -6, 0], radius=3.0)), True),
    "a force on a part without a radius": (loads(push=push(centre=[12, -6])), True),
    "a force on a part without a centre": (loads(push=push(radius=3.0)), True),
    "a force on nothing": (loads(push=push(boundary="nothing")), True),
    "a force along nothing": (loads(push=push(direction=[0, 0])), True),
    "a force of 1e20": (loads(push=push(history=[{"ramp": 1e20, "until": 1, "steps": 1}])), None),
    "a shape": (loads(mode=mode([[1e-3, 0], [1e-3, 0]])), False),
    "a shape of nothing": (loads(mode=mode([[0, 0], [0, 0]])), True),
    "a shape of 1e-29": (loads(mode=mode([[1e-29, 0], [0, 0]])), None),
    "a shape of 1e20": (loads(mode=mode([[1e20, 0], [0, 0]])), None),
    "a shape of nan": (loads(mode=mode([[float("nan"), 0], [0, 0]])), True),
    "a shape of one component": (loads(mode=mode([[1e-3], [0]])), True),
    "a shape of fewer values": (loads(mode=mode([[1e-3, 0]])), True),
    "a shape of a contact surface": (
        loads(mode=mode([[1e-3, 0], [0, 0]], boundary="lower_contact")), True,
    ),
    "a shape of what is held": (
        loads(mode=mode([[1e-3, 0], [0, 0]], boundary="lower_bottom")), True,
    ),
    "a shape of a platen": (loads(mode=mode([[1e-3, 0], [0, 0]], boundary="upper_top")), True),
    "two shapes of one boundary": (
        loads(mode=mode([[1e-3, 0], [0, 0]]), more=mode([[1e-3, 0], [0, 0]])), True,
    ),
    "a shape backwards in size": (loads(mode=mode([[1e-3, 0], [0, 0]], factor=-1.0)), True),
    "a fit that is true": (
        loads(fit={"type": "interference", "contact": "main", "history": True}), True,
    ),
    "gravity without density": (
        loads(fall={"type": "acceleration", "direction": "y", "history": RAMP}), True,
    ),
    "gravity along nothing": (
        {**bodies(density=1.0),
         **loads(fall={"type": "acceleration", "direction": [0, 0], "history": RAMP})}, True,
    ),
    "a z in the plane": (loads(pull=pull("lower_left", direction="z")), True),
    "a vector of three in the plane": (loads(pull=pull("lower_left", direction=[1, 0, 0])), True),
    "two platen loads along one line": (loads(more=press(steps=1)), True),
    "two platen loads askew": (
        loads(more={**press(steps=1), "direction": [1, 1]}), True,
    ),
    "a tilt about x in the plane": (
        loads(tilt={"type": "tilt", "boundary": "upper_top", "axis": "x", "centre": [0, 0],
                    "control": "moment", "history": [{"ramp": 1, "until": 1, "steps": 1}]}), True,
    ),
    "a cycle without steps at its ends": ({"cycle": {"start": 0.123, "end": 1.5}}, True),
    "a cycle behind the end": ({"cycle": {"start": 5.0, "end": 6.0}}, True),
    "fields at no step": ({"output": {"fields": [0.123]}}, True),
    "a radius of 1e9": (parameters(upper_radius=1e9), None),
    "a radius smaller than the width": (parameters(upper_radius=1.0), True),
    "elements of 1e-9": (parameters(size=1e-9), True),
    "elements larger than the body": (parameters(size=1e3), True),
    "an unknown parameter": (parameters(nonsense=1.0), True),
    "a platen in the air": (
        {"loads": {"press": {**TOP, "direction": "y", "control": "displacement",
                             "history": [{"ramp": 100.0, "until": 1.0, "steps": 1}]}}}, True,
    ),
    "a platen pressed through": (
        {"loads": {"press": {**TOP, "direction": "y", "control": "displacement",
                             "history": [{"ramp": -30.0, "until": 1.0, "steps": 1}]}}}, None,
    ),
    "pushed from the side": ({"supports": {**BASE, "side": SIDE}}, None),
}  # fmt: skip


def faults() -> Iterator[Fault]:
    """All of them."""
    for name, (tables, refused) in MODELS.items():
        text = tomli_w.dumps({**copy.deepcopy(PAD), **tables})
        yield text_fault(f"model/{name}/run", FEM, text, refused)
        # What only solving shows is not refused by others.
        only_solved = name in (
            *("pulled apart", "sheared away", "a platen in the air", "no friction"),
            "a z in the plane",  # which friction might hold
        )
        yield text_fault(f"model/{name}/check", CHECK, text, None if only_solved else refused)
        yield text_fault(f"model/{name}/half-planes", HALFPLANE, text)
    for name in ("no supports", "support on a contact surface", "load on nothing", "rigid"):
        tables, refused = MODELS[name]
        text = tomli_w.dumps({**copy.deepcopy(SOLID), **tables})
        yield text_fault(f"model/{name}/solid", FEM if name == "rigid" else CHECK, text, refused)
