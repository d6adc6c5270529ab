# SPDX-License-Identifier: LGPL-3.0-or-later
"""First jobs: cases drawn from what the guide of the case file allows, not from what is usual.

Every load may do anything in every block of the clock: wait, change, wave, go through points, end
at zero. Hypothesis draws, so that what fails arrives as its smallest case. What is expected of a
job, the evaluated cycle and the factors of a cylinder, is computed here from the tables, without
code of fretfe.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st

Tables = dict[str, Any]
Segments = list[dict[str, Any]]

# Half-width of the contact at the highest load, in the unit of length; the bodies are large
# multiples of it.
HALF_WIDTH, BODY, RADIUS, POISSON = 1.0, 40.0, 200.0, 0.3
TOP = {"type": "platen", "boundary": "upper_top", "control": "force"}


@dataclass(frozen=True, repr=False)
class Job:
    """A case of one pad on a block.

    Attributes:
        tables: of the case file.
        cycle: times between which the case asks for an evaluation; None for the whole history.
        peak: normal force that makes the half-width, per unit thickness.
        shares: (n, 4) time, P over `peak`, Q over f `peak` and the bulk tension over f p0 at many
            times, straight lines between; p0 is `peak` over twice the half-width.
    """

    tables: Tables
    cycle: tuple[float, float] | None
    peak: float
    shares: np.ndarray

    def __repr__(self) -> str:
        """The case, as it can be run again."""
        return f"Job({self.tables!r})"

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        """As `repr`, which Hypothesis asks for in this way."""
        printer.text(repr(self))

    @property
    def template(self) -> str:
        """Of the geometry."""
        return str(self.tables["geometry"]["template"])

    @property
    def friction(self) -> float:
        """Coefficient."""
        return float(self.tables["contacts"]["main"]["friction"])

    @property
    def unsolvable(self) -> bool:
        """True if the contact is (nearly) open, or slides as a whole, in some state."""
        late = self.shares[:, 0] >= 1.0
        normal, shear = self.shares[late, 1], self.shares[late, 2]
        starting = self.shares[self.shares[:, 0] <= 1.0]
        bound = (
            0.0
            if any("friction_from" in each for each in self.tables["contacts"].values())
            else 0.95
        )
        slides = np.abs(starting[:, 2]) > bound * starting[:, 1] + 1e-12
        return bool((normal < 0.02).any() or (np.abs(shear) > 0.95 * normal).any() or slides.any())


# A load in one block of the clock: what it does and where it goes, over its largest value.
TARGETS = st.sampled_from([0.0, 0.5, -0.5, 0.8, -0.8, 0.1, 1e-9, 0.25])
AMPLITUDES = st.sampled_from([0.0, 0.4, 0.1, 1e-9, 0.02])
BLOCKS = st.one_of(
    st.just(("hold",)),
    st.tuples(st.just("ramp"), TARGETS, st.sampled_from([1, 2, 5])),
    st.tuples(
        st.just("wave"),
        AMPLITUDES,
        st.sampled_from([1.0, 0.5]),
        st.sampled_from([0.0, 90.0, 180.0, -60.0]),
        st.sampled_from([8, 4, 12, 5]),
        st.sampled_from(["sine", "triangle"]),
    ),
    st.tuples(st.just("points"), TARGETS, TARGETS, TARGETS),
)


def history(
    blocks: list[tuple[Any, ...]], size: float, within: tuple[float, float], first: float
) -> tuple[Segments, np.ndarray]:
    """Segments of a load that does one thing in each unit of time from 1 on, and its shares.

    Args:
        blocks: what it does.
        size: of the load at a share of 1.
        within: shares to which targets from -1 to 1 are mapped.
        first: share at time 1, reached by a ramp; nothing happens before if it is zero.
    """
    middle, half = (within[0] + within[1]) / 2, (within[1] - within[0]) / 2
    segments: Segments = []
    if first:
        segments.append({"ramp": first * size, "until": 1.0, "steps": 3})
    else:
        segments.append({"hold": True, "until": 1.0})
    places, value = [(0.0, 0.0), (1.0, first)], first
    for start, block in enumerate(blocks, start=1):
        kind, *rest = block
        if kind == "hold":
            segments.append({"hold": True, "until": start + 1.0})
        elif kind == "ramp":
            value = middle + half * rest[0]
            segments.append({"ramp": value * size, "until": start + 1.0, "steps": rest[1]})
        elif kind == "points":
            times = [start + 0.25, start + 0.75, start + 1.0]
            shares = [middle + half * each for each in rest]
            segments.append({"times": times, "values": [each * size for each in shares]})
            places += pairwise_points(times, shares)
            value = shares[-1]
        else:
            amplitude, period, phase, steps, shape = rest
            amplitude *= half
            mean = value - amplitude * _shape(shape, phase / 360)
            # The wave stays within the bounds of the load.
            mean_in = min(max(mean, within[0] + amplitude), within[1] - amplitude)
            if abs(mean_in - mean) > 1e-12:
                amplitude, mean_in = 0.0, value
            segments.append(
                {
                    "wave": shape,
                    "mean": mean_in * size,
                    "amplitude": amplitude * size,
                    "phase": phase,
                    "period": period,
                    "cycles": round(1 / period),
                    "steps_per_cycle": steps,
                }
            )
            inner = np.linspace(0.0, 1.0, 241)[1:]
            places += [
                (start + t, mean_in + amplitude * _shape(shape, t / period + phase / 360))
                for t in inner.tolist()
            ]
        places.append((start + 1.0, value))
    return segments, np.array(places)


def pairwise_points(times: list[float], shares: list[float]) -> list[tuple[float, float]]:
    """Points of a table but for the last one."""
    return list(zip(times[:-1], shares[:-1], strict=True))


def _shape(shape: str, turns: float) -> float:
    if shape == "sine":
        return math.sin(2 * math.pi * turns)
    part = (turns + 0.25) % 1.0
    return 1 - 4 * abs(part - 0.5)


def asked_cycle(tables: Tables) -> tuple[float, float] | None:
    """Times of the evaluated cycle by the words of the guide: as given, or the slowest wave's."""
    given = tables.get("cycle", {})
    if "start" in given:
        return given["start"], given["end"]
    waves = []
    for load in tables["loads"].values():
        time = 0.0
        for segment in load["history"]:
            if "wave" in segment:
                time += segment["period"] * segment["cycles"]
                waves.append((segment["period"], time))
            else:
                time = segment["times"][-1] if "times" in segment else segment["until"]
    if not waves:
        return None
    period, end = max(waves)
    return end - period, end


@st.composite
def pads(draw: st.DrawFn, per_half_width: int, profiles: tuple[str, ...] = ("cylinder",)) -> Job:
    """A pad on a block, with elements that many over the half-width."""
    profile = draw(st.sampled_from(profiles))
    count = draw(st.integers(1, 4))
    friction = draw(st.sampled_from([0.4, 0.9, 0.1, 2.0, 1e6, 0.01, 0.0]))
    young = (210e3, draw(st.sampled_from([210e3, 210e3, 210e3, 70e3])))
    plane = draw(st.sampled_from(["strain", "stress"]))
    thickness = draw(st.sampled_from([1.0, 4.0]))
    parameters, peak = geometry(profile, per_half_width, modulus(young, plane))
    twice = draw(st.booleans())

    def blocks() -> list[tuple[Any, ...]]:
        found = draw(st.lists(BLOCKS, min_size=count, max_size=count))
        # Cycles start twice, or go on: what a load does in the first block it does once more.
        return [*found[:1], *found] if twice else found

    pressing, shearing = blocks(), blocks()
    range_p = draw(st.sampled_from([(0.5, 1.0), (0.5, 1.0), (0.0, 1.0)]))
    range_q = draw(st.sampled_from([(-0.45, 0.45), (-0.2, 0.45), (-1.0, 1.0), (0.0, 1e-9)]))
    bound = min(friction, 2.0)
    together = draw(st.booleans())
    press, p = history(pressing, -peak * thickness, range_p, 0.75 if range_p[0] else 0.5)
    started = draw(st.sampled_from([0.0, 0.2, -0.3])) if together else 0.0
    shear, q = history(shearing, bound * peak * thickness, range_q, started)
    loads: Tables = {
        "press": {**TOP, "direction": "y", "history": press},
        "shear": {**TOP, "direction": "x", "history": shear},
    }
    supports: Tables = {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}}
    tensions = [np.array([[0.0, 0.0], [1.0, 0.0]])]
    pulled = draw(st.sampled_from([False, False, True]))
    if pulled:
        unit = bound * peak / (2 * HALF_WIDTH)
        tension, told = history(blocks(), unit, (-0.3, 0.3), 0.0)
        tensions = [told]
        side = {"type": "traction", "boundary": "lower_right", "direction": "normal"}
        loads["tension"] = {**side, "history": tension}
        supports["base"]["fix"] = ["y"]
        supports["side"] = {"boundary": "lower_left", "fix": ["x"]}
    if draw(st.integers(0, 5)) == 5 and not pulled:
        del loads["shear"]
        q = np.array([[0.0, 0.0], [1.0, 0.0]])
    degree = draw(st.sampled_from([2, 1]))
    tables: Tables = {
        "model": {"plane": plane, "thickness": thickness, "degree": degree},
        "geometry": {"template": profile, "parameters": parameters, "order": degree},
        "bodies": {
            name: {"young": each, "poisson": POISSON}
            for name, each in zip(("upper", "lower"), young, strict=True)
        },
        "contacts": {
            "main": {
                "surface1": "upper_contact",
                "surface2": "lower_contact",
                "friction": friction,
                **draw(st.sampled_from([{"friction_from": 1.0}, {}])),
            }
        },
        "supports": supports,
        "loads": loads,
        "output": {"fields": "none"},
    }
    cycle = draw(cycles(count + twice))
    if cycle:
        tables["cycle"] = cycle
    return Job(tables, asked_cycle(tables), peak, shares_of(p, q, tensions[0]))


@st.composite
def cycles(draw: st.DrawFn, blocks: int) -> Tables:
    """A table [cycle], or none: any blocks that follow one another."""
    told: Tables = {}
    if draw(st.booleans()):
        start = draw(st.integers(1, blocks))
        told |= {"start": float(start), "end": float(draw(st.integers(start + 1, blocks + 1)))}
    if draw(st.booleans()):
        told["until_steady"] = draw(st.booleans())
    return told


def shares_of(*each: np.ndarray) -> np.ndarray:
    """(n, 1 + loads) at the times of all of them."""
    times = np.unique(np.concatenate([one[:, 0] for one in each]))
    return np.column_stack([times, *(np.interp(times, one[:, 0], one[:, 1]) for one in each)])


def modulus(young: tuple[float, float], plane: str) -> float:
    """E* of both bodies (theory guide, section 1)."""
    each = 1 - POISSON**2 if plane == "strain" else 1.0
    return 1 / sum(each / one for one in young)


def geometry(profile: str, per_half_width: int, e_star: float) -> tuple[Tables, float]:
    """Parameters of a template, and the normal force that makes the half-width."""
    a, size = HALF_WIDTH, HALF_WIDTH / per_half_width
    body = {f"{each}_{side}": BODY * a for each in ("upper", "lower") for side in WIDE}
    shared = {**body, "zone": 1.6 * a, "growth": 0.3}
    if profile == "cylinder":
        own = {"upper_radius": RADIUS, "lower_radius": 0.0, "size": size}
        return {**shared, **own}, math.pi * e_star * a**2 / (4 * RADIUS)
    if profile == "wedge":
        angle = 0.5
        return {**shared, "angle": angle, "size": size}, e_star * math.tan(math.radians(angle)) * a
    flat = 0.5 * a
    turn = math.asin(flat / a)
    peak = e_star * a**2 / (2 * RADIUS) * (math.pi - 2 * turn - math.sin(2 * turn)) / 2
    own = {
        "flat_half_width": flat,
        "radius": RADIUS,
        "edge_size": size / 2,
        "flat_size": size,
    }
    return {**shared, **own}, peak


WIDE = ("width", "height")


def exact_factors(job: Job) -> tuple[float, float] | None:
    """K_N at the end of the evaluated cycle and the range of K over it; None if not so simple.

    Equal bodies with friction in the cycle only.
    """
    bodies = job.tables["bodies"]
    if job.cycle is None or bodies["upper"] != bodies["lower"] or job.unsolvable:
        return None
    if job.friction == 0:
        return None
    inside = (job.shares[:, 0] >= job.cycle[0] - 1e-9) & (job.shares[:, 0] <= job.cycle[1] + 1e-9)
    # Straight lines between are divided so that the half-width hardly changes in each of them.
    shares = job.shares[inside, 1:]
    fine = np.linspace(0.0, len(shares) - 1.0, 40 * (len(shares) - 1) + 1)
    normal, shear, tension = (np.interp(fine, np.arange(len(shares)), each) for each in shares.T)
    if job.template == "cylinder":
        return _of_cylinder(job, normal, shear, tension)
    if job.template == "sphere" and "across" not in job.tables["loads"]:
        return _of_sphere(job, normal, shear)
    return None


def _of_cylinder(
    job: Job, normal: np.ndarray, shear: np.ndarray, tension: np.ndarray
) -> tuple[float, float]:
    """Of the edge with the larger range of K_T.

    Hertz, K_N = E* sqrt(2a)/(2R); increments of full stick, dK_T = dQ/(pi sqrt(2a)) and those of
    the tension, ±dsigma sqrt(a/2)/4 (theory guide).
    """
    young = job.tables["bodies"]["upper"]["young"]
    e_star = modulus((young, young), job.tables["model"]["plane"])
    bound = min(job.friction, 2.0)
    a = HALF_WIDTH * np.sqrt((normal[1:] + normal[:-1]) / 2)
    by_shear = np.diff(shear) * bound * job.peak / (math.pi * np.sqrt(2 * a))
    sigma = tension * bound * job.peak / (2 * HALF_WIDTH)
    if "side" in job.tables["supports"]:
        # The block is held at its left side, which carries all of Q: Q/2 over its height beneath.
        sigma = sigma + shear * bound * job.peak / (2 * BODY * HALF_WIDTH)
    by_tension = np.diff(sigma) * np.sqrt(a / 2) / 4
    ranges = [
        np.ptp(np.append(0.0, np.cumsum(by_shear + sign * by_tension))) for sign in (1.0, -1.0)
    ]
    last = HALF_WIDTH * math.sqrt(normal[-1])
    return e_star * math.sqrt(2 * last) / (2 * RADIUS), float(max(ranges))


def _of_sphere(job: Job, normal: np.ndarray, shear: np.ndarray) -> tuple[float, float]:
    """All around: K_N = 3P/(2 pi a^2) sqrt(2/a) and, bonded, d|K| = dQ/(2 pi a sqrt(2a))."""
    bound = min(job.friction, 2.0) * job.peak
    a = HALF_WIDTH * np.cbrt((normal[1:] + normal[:-1]) / 2)
    steps = np.diff(shear) * bound / (2 * math.pi * a * np.sqrt(2 * a))
    last = HALF_WIDTH * np.cbrt(normal[-1])
    k_n = 3 * normal[-1] * job.peak / (2 * math.pi * last**2) * math.sqrt(2 / last)
    return float(k_n), float(np.ptp(np.append(0.0, np.cumsum(steps))))


def cyclic_slip(job: Job) -> float | None:
    """Slip zone of a cylinder or sphere whose Q alone repeats itself.

    Each half cycle of the second of two equal cycles has the full range: a (1 - (1 - range/(2 f
    P))^n), n = 1/2 by Cattaneo for a cylinder, 1/3 by Mindlin for a sphere (theory guide). None
    where it is not known so simply.
    """
    if job.cycle is None or exact_factors(job) is None:
        return None
    start, end = job.cycle
    before = start - (end - start)
    times, normal, shear, _ = job.shares.T
    if before < 1.0:
        return None
    at = np.linspace(0.0, end - start, 481)
    now, earlier = (np.interp(from_ + at, times, shear) for from_ in (start, before))
    whole = (times >= before - 1e-9) & (times <= end + 1e-9)
    if (
        np.ptp(normal[whole])
        or "side" in job.tables["supports"]
        or not np.allclose(now, earlier, atol=1e-12)
    ):
        return None
    bound = min(job.friction, 2.0)
    share = np.ptp(now) * bound / (2 * job.friction * normal[whole][0])
    exponent = 1 / 3 if job.template == "sphere" else 1 / 2
    return float(HALF_WIDTH * normal[whole][0] ** exponent * (1 - (1 - share) ** exponent))


# What may drive a blade: the table of the load, and its size at a share of 1.
DRIVEN: dict[str, tuple[Tables, float]] = {
    "pull": ({"type": "platen", "boundary": "blade_top", "control": "force"}, 3900.0),
    "push": ({"type": "platen", "boundary": "blade_top", "control": "displacement"}, 0.03),
    "traction": ({"type": "traction", "boundary": "blade_top"}, 300.0),
    "speed": ({"type": "rotation", "centre": [0.0, -250.0]}, 3400.0),
}
COARSE = {"edge_size": 0.05, "edge_zone": 0.2, "flank_size": 0.5, "growth": 0.4}
# Of spheres: one that has no stations, and the coarsest that has all of them.
FRONT_SIZE, KNOWN_SIZE = 0.25, 0.125


@st.composite
def blades(draw: st.DrawFn) -> Job:
    """A dovetail or firtree, coarsely meshed, under one load that may come and go."""
    template, sides = draw(
        st.sampled_from(
            [("dovetail", ("left", "right")), ("firtree", ("left_1", "left_2", "right_1"))]
        )
    )
    sides = sides if template == "dovetail" else (*sides, "right_2")
    parameters = {**COARSE, **({"lobes": 2} if template == "firtree" else {})}
    driven = draw(st.sampled_from(list(DRIVEN)))
    table, size = DRIVEN[driven]
    count = draw(st.integers(1, 3))
    blocks = draw(st.lists(BLOCKS, min_size=count, max_size=count))
    segments, told = history(blocks, size, draw(st.sampled_from([(0.0, 1.0), (0.4, 1.0)])), 0.7)
    along = {} if driven == "speed" else {"direction": "y"}
    loads: Tables = {driven: {**table, **along, "history": segments}}
    if driven in ("speed", "traction"):
        still = {"direction": "x", "history": [{"hold": True, "until": 1.0}]}
        loads["guide"] = {"type": "displacement", "boundary": "blade_top", **still}
    tables: Tables = {
        "geometry": {"template": template, "parameters": parameters},
        "bodies": {
            name: {"young": 115e3, "poisson": 0.32, "density": 4.4e-9} for name in ("blade", "disc")
        },
        "contacts": {
            f"flank_{side}": {
                "surface1": f"blade_flank_{side}",
                "surface2": f"disc_flank_{side}",
                "friction": draw(st.sampled_from([0.4, 0.1, 0.9, 0.0])),
            }
            for side in sides
        },
        "supports": {"rim": {"boundary": "disc_bottom", "fix": ["x", "y"]}},
        "loads": loads,
        "output": {"fields": "none"},
    }
    if cycle := draw(cycles(count)):
        tables["cycle"] = cycle
    nothing = np.zeros((2, 2))
    nothing[1, 0] = 1.0
    return Job(tables, asked_cycle(tables), 1.0, shares_of(told, nothing, nothing))


@st.composite
def spheres(draw: st.DrawFn, known: bool = False) -> Job:
    """A sphere on a block: a coarse one under P and Q, which may turn, or one that is `known`.

    That has stations, bodies that are next to half-spaces, and P that stays while Q varies twice.
    """
    radius, reach, wide = 50.0, HALF_WIDTH, 20.0 if known else 8.0
    peak = 4 * modulus((210e3, 210e3), "strain") * reach**3 / (3 * radius)
    friction = draw(st.sampled_from([0.4, 0.9] if known else [0.4, 0.9, 1e6, 0.0]))
    count = 1 if known else draw(st.integers(1, 2))
    blocks = [draw(st.lists(BLOCKS, min_size=count, max_size=count)) for _ in "pqr"]
    if known:
        count, blocks = 2, [[("hold",)] * 2, 2 * blocks[1]]
    press, p = history(blocks[0], -peak, (0.5, 1.0), 1.0 if known else 0.75)
    bound = min(friction, 2.0) * peak
    shear, q = history(blocks[1], bound, (-0.6, 0.6) if known else (-0.3, 0.3), 0.0)
    loads: Tables = {
        "press": {**TOP, "direction": "y", "history": press},
        "shear": {**TOP, "direction": "x", "history": shear},
    }
    if not known and draw(st.booleans()):
        across, _ = history(blocks[2], bound, (-0.15, 0.15), 0.0)
        loads["across"] = {**TOP, "direction": "z", "history": across}
    tables: Tables = {
        "geometry": {
            "template": "sphere",
            "parameters": {
                "radius_x": radius,
                "contact_x": reach,
                "size": KNOWN_SIZE if known else FRONT_SIZE,
                **{f"{body}_{side}": wide for body in ("upper", "lower") for side in WIDE},
            },
        },
        "bodies": {name: {"young": 210e3, "poisson": POISSON} for name in ("upper", "lower")},
        "contacts": {
            "main": {
                "surface1": "upper_contact",
                "surface2": "lower_contact",
                "friction": friction,
                "friction_from": 1.0,
            }
        },
        "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}},
        "loads": loads,
        "output": {"fields": "none"},
        "edges": {"stations": 8},
        "cycle": {**draw(cycles(count)), "more": 0},
    }
    still = np.array([[0.0, 0.0], [1.0, 0.0]])
    return Job(tables, asked_cycle(tables), peak, shares_of(p, q, still))
