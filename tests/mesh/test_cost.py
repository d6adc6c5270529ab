# SPDX-License-Identifier: LGPL-3.0-or-later
"""Estimates of memory and time, and the refusal of what cannot fit."""

from __future__ import annotations

from dataclasses import replace

import pytest
from cases import blocks

from fretfe.case import Solid
from fretfe.environment import machine_memory
from fretfe.errors import ModelError
from fretfe.mesh import cost
from fretfe.mesh.cost import Amount, BodySizes, estimate_cost, refuse_too_large
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import Mesh

GB = 2**30


def mesh() -> Mesh:
    lines = blocks.graded(0.0, 1.5, 40), blocks.graded(0.0, 1.0, 30)
    return Mesh({"b": blocks.block("b", *lines)})


def test_the_machine_tells_its_memory() -> None:
    there = machine_memory()
    assert there is not None
    assert GB / 4 < there < 2**50


def test_cost_grows_with_tractions_and_steps() -> None:
    small = estimate_cost(BodySizes.of(mesh(), 2), nodes=40, amount=Amount(100))
    assert small.tractions == 80
    assert small.text.startswith(f"{small.unknowns} unknowns, 80 contact tractions, 100 steps: ")
    assert (
        estimate_cost(BodySizes.of(mesh(), 2), nodes=5000, amount=Amount(100)).memory
        > 10 * small.memory
    )
    longer = estimate_cost(BodySizes.of(mesh(), 2), nodes=40, amount=Amount(100_000))
    assert longer.memory == small.memory  # a history is streamed to a file
    assert longer.seconds > 300
    assert "min" in longer.text
    assert " h, " in estimate_cost(BodySizes.of(mesh(), 2), nodes=40, amount=Amount(10**7)).text


def test_steps_through_zero_load_have_a_range() -> None:
    whole = estimate_cost(BodySizes.of(mesh(), 2), nodes=150, amount=Amount(16))
    assert replace(whole, unloaded=1, divided=2).text == whole.text
    parted = replace(whole, unloaded=3, divided=64)
    assert parted.longest == pytest.approx(whole.seconds + 10 * 3 * 64 * whole.step)
    assert parted.text.startswith(whole.text + "; up to ")
    assert "as 3 later steps begin or end without load" in parted.text


def test_what_is_behind_the_last_step_counts() -> None:
    """The dovetail of docs/performance.md: 1.8 s for edge factors, .7 s for fields, 7 s to draw."""
    found = estimate_cost(BodySizes.of(mesh(), 2), nodes=40, amount=Amount(100, 4, 3))
    without = estimate_cost(BodySizes.of(mesh(), 2), nodes=40, amount=Amount(100))
    assert found.seconds - without.seconds == pytest.approx(found.behind - without.behind)
    scale = found.unknowns / 114_096
    assert found.behind - without.behind == pytest.approx((1.8 + 0.7) * scale, rel=0.3)
    assert without.behind - cost.DRAWING[2] == pytest.approx(
        (7.0 - cost.DRAWING[2]) * scale, rel=0.3
    )
    assert found.text.endswith(" of them for edge factors, fields and pictures")


def test_what_cannot_fit_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    found = estimate_cost(BodySizes.of(mesh(), 2), nodes=40, amount=Amount(100))
    refuse_too_large(found)
    monkeypatch.setattr(cost, "machine_memory", lambda: 4 * GB)
    large = replace(found, unknowns=2_000_000, memory=8.0 * GB)
    expected = r"memory of this machine \(4 GB\), found one that needs about 8 GB \(2000000 unk"
    with pytest.raises(ModelError, match=expected) as caught:
        refuse_too_large(large)
    assert "About 1000000 unknowns would fit: make the elements larger" in str(caught.value)
    monkeypatch.setattr(cost, "machine_memory", lambda: None)
    refuse_too_large(large)


def test_factors_go_to_disk_where_memory_is_short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cost, "machine_memory", lambda: None)
    there = estimate_cost(BodySizes.of(solid(20, 4), 2), nodes=300, amount=Amount(10))
    assert not there.on_disk
    for share, on_disk in ((0.9, False), (1.1, True)):
        monkeypatch.setattr(
            cost, "machine_memory", lambda share=share: there.memory / cost.IN_MEMORY / share
        )
        found = estimate_cost(BodySizes.of(solid(20, 4), 2), nodes=300, amount=Amount(10))
        assert found.on_disk is on_disk
        assert (found.memory < there.memory) is on_disk
        assert ("GB (factors on disk) and" in found.text) is on_disk


def solid(cells: int, layers: int) -> Mesh:
    lines = blocks.graded(0.0, 1.0, cells), blocks.graded(0.0, 1.0, cells)
    flat = Mesh({"b": blocks.block("b", *lines)})
    return extrude(flat, Solid(length=1.0, skew=0.0, layers=layers))


@pytest.mark.parametrize(("cells", "layers", "measured"), [(10, 10, 190), (40, 2, 530)])
def test_a_solid_costs_what_was_measured(cells: int, layers: int, measured: int) -> None:
    """MiB by which a process grew, which differ by 15 % from one time to the next."""
    found = estimate_cost(BodySizes.of(solid(cells, layers), 2), nodes=0, amount=Amount(0))
    assert found.unknowns == 3 * (2 * cells + 1) ** 2 * (2 * layers + 1)
    factor = found.memory - cost.ALWAYS - cost.PER_UNKNOWN[3] * found.unknowns
    assert factor / 2**20 == pytest.approx(measured, rel=0.2)
    assert (
        estimate_cost(BodySizes.of(solid(cells, layers), 1), nodes=0, amount=Amount(0)).memory
        < found.memory
    )


def test_a_thin_solid_costs_less_than_a_thick_one() -> None:
    sizes = (20, 20), (60, 2)
    thick, thin = (estimate_cost(BodySizes.of(solid(*each), 2), 0, Amount()) for each in sizes)
    assert thick.unknowns < thin.unknowns
    assert thick.memory > thin.memory


def test_halves_are_separated_across_the_longest_axis() -> None:
    """A bar of 8 x 2 x 2 cubes: 9 nodes between the halves, 9 within each of them."""
    lines = range(9), range(3)
    bar = extrude(Mesh({"b": blocks.block("b", *lines)}), Solid(length=2.0, skew=0.0, layers=2))
    body = bar.bodies["b"]
    assert cost._squared_separators(body.points, body.cells[:, :8], 1) == (9, 0)
    assert cost._squared_separators(body.points, body.cells[:, :8], 2) == (9, 2 * 9**2)


def test_a_solid_that_cannot_fit_gets_a_proposal(monkeypatch: pytest.MonkeyPatch) -> None:
    found = estimate_cost(BodySizes.of(solid(10, 10), 2), nodes=100, amount=Amount(100))
    monkeypatch.setattr(cost, "machine_memory", lambda: 4 * GB)
    with pytest.raises(ModelError, match="take fewer, longer layers along the edge") as caught:
        refuse_too_large(replace(found, unknowns=800_000, memory=32.0 * GB))
    # a factor's memory grows with the power of 4/3
    # 800 000/8^.75 = 168 179
    assert "About 170000 unknowns would fit" in str(caught.value)


def test_a_contact_that_cannot_fit_gets_a_proposal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Full matrices of n tractions take 8 n² bytes each."""
    dense = 8.0 * cost.MATRICES[3] * 32_000**2
    found = replace(
        estimate_cost(BodySizes.of(solid(10, 10), 2), nodes=100, amount=Amount(100)),
        tractions=32_000, dense=dense, memory=dense + 4 * GB,
    )  # fmt: skip
    assert "38 GB of them for the contact tractions" in found.text
    monkeypatch.setattr(cost, "machine_memory", lambda: 4 * GB + dense / 4)
    with pytest.raises(ModelError, match="layers along the edge") as caught:
        refuse_too_large(found)
    assert "About 16000 contact tractions would fit" in str(caught.value)


def test_processes_share_bodies_and_steps() -> None:
    """Two bodies of one size: each its own, and the matrices of the contact on the first."""
    both = Mesh({name: mesh().bodies["b"] for name in ("a", "b")})
    sizes = BodySizes.of(both, 2)
    one, two, eight = (estimate_cost(sizes, 400, Amount(100), ranks=n) for n in (1, 2, 8))
    bodies = one.memory - cost.ALWAYS - one.dense
    assert two.memory == pytest.approx(cost.ALWAYS + one.dense + bodies / 2)
    assert eight.memory == pytest.approx(cost.ALWAYS + one.dense + bodies / 2 * 4**-0.9)
    assert two.step - cost.STEP == pytest.approx(0.625 * (one.step - cost.STEP))
    more = 7 * cost.ALWAYS + bodies * (4**0.1 - 1)
    assert eight.memory + eight.others == pytest.approx(one.memory + more)
    assert one.seconds > two.seconds > eight.seconds
    assert f"{two.seconds / one.seconds:.2g} of that" in two.beside(one)


def test_processes_fit_cores_and_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each takes 0.25 GB besides what they share."""
    sizes = BodySizes.of(mesh(), 2)
    one, eight = (estimate_cost(sizes, 400, Amount(100), ranks=n) for n in (1, 8))
    assert "GB for the largest of them, 2.1 GB for all, and" in eight.beside(one)
    for memory, most in ((64.0 * GB, 8), (one.memory + 2.5 * cost.ALWAYS, 3)):
        monkeypatch.setattr(cost, "machine_memory", lambda memory=memory: memory)
        assert [n for n in range(1, 9) if estimate_cost(sizes, 400, Amount(100), n).fits][
            -1
        ] == most
    with pytest.raises(ModelError, match="that fits into the memory of this machine"):
        refuse_too_large(eight)


def test_bodies_condensed_beside_one_another_have_fronts_of_their_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With factors on disk, where the matrices of the contact are the most."""
    sizes = BodySizes.of(Mesh({name: solid(10, 10).bodies["b"] for name in ("a", "b")}), 2)
    monkeypatch.setattr(cost, "machine_memory", lambda: 0.1 * GB)
    one, two = (estimate_cost(sizes, 3000, Amount(), ranks=n) for n in (1, 2))
    assert one.on_disk and two.on_disk
    full = 8.0 * 9000.0**2
    front = cost.FRONTS * 8.0 * (9000.0 + sizes.separators[0]) ** 2
    assert one.dense == pytest.approx(max(1.5 * full + front, cost.MATRICES_ON_DISK * full))
    both = two.memory + two.others - one.memory - one.others - cost.ALWAYS
    assert both == pytest.approx(2 * (full + front) - one.dense)
