# SPDX-License-Identifier: LGPL-3.0-or-later
"""Arrays over the states of a history that are read from a file where they are needed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
from numpy.typing import NDArray

from fretfe._typing import Indices

# Values that are looked at together, in bytes: many states of a small contact, few of a large one.
BLOCK = 1 << 20
MOST_STATES = 256


@dataclass(frozen=True, eq=False)
class StateArray(NDArrayOperatorsMixin):
    """An array (T, ...) of which the states asked for are read: ``array[3]``, ``array[2:5, :, 0]``.

    In an expression it is the whole array; so is ``numpy.asarray(array)``.

    Attributes:
        shape: of the whole array.
        dtype: of its elements.
        read: gives (n, ...) values of n states (n,), in any order.
    """

    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    read: Callable[[Indices], Any]

    def __len__(self) -> int:
        """T."""
        return self.shape[0]

    def __getitem__(self, key: Any) -> Any:
        """Values of some states, as of an array in memory; the states come first in the key."""
        first, *rest = key if isinstance(key, tuple) else (key,)
        if first is Ellipsis:
            return np.asarray(self)[key]
        states = np.arange(len(self))[first]
        if states.ndim == 0:
            return self.read(states[None])[0][tuple(rest)]
        return self.read(states)[(slice(None), *rest)]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        """All of it, in memory."""
        return np.asarray(self.read(np.arange(len(self))), dtype=dtype)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        """Take part in an expression of NumPy with all of it."""
        arrays = [np.asarray(each) if isinstance(each, StateArray) else each for each in inputs]
        return getattr(ufunc, method)(*arrays, **kwargs)


def mapped(values: StateArray | NDArray[Any], change: Callable[[Any, Indices], Any]) -> StateArray:
    """An array after a change of (n, ...) values that keeps their shape, given n states (n,)."""
    return StateArray(values.shape, values.dtype, lambda states: change(values[states], states))


def picked(values: StateArray | NDArray[Any], rows: Indices) -> StateArray:
    """An array of some of the states (n,), in any order."""
    shape = (len(rows), *values.shape[1:])
    return StateArray(shape, values.dtype, lambda states: values[rows[states]])


def summed(values: StateArray | NDArray[Any], ends: Indices) -> StateArray:
    """An array (n, ...) of sums over all states behind the end before, up to each of the ends (n,).

    Args:
        values: (T, ...).
        ends: (n,) increasing.
    """
    begins = np.append(0, ends[:-1] + 1)

    def read(states: Indices) -> Any:
        return np.array([values[begins[n] : ends[n] + 1].sum(axis=0) for n in states])

    return StateArray((len(ends), *values.shape[1:]), values.dtype, read)


def part(values: StateArray | NDArray[Any], key: Any) -> StateArray:
    """An array of a part of the last axis."""
    *shape, size = values.shape
    kept = np.arange(size)[key].shape
    return StateArray((*shape, *kept), values.dtype, lambda states: values[states][..., key])


def blocks(count: int, size: int) -> Iterator[slice]:
    """Ranges of states, one after the other, of an array that fits into memory block by block.

    Args:
        count: T.
        size: elements of one state.
    """
    length = states_in_block(8 * size)
    for start in range(0, count, length):
        yield slice(start, min(start + length, count))


def states_in_block(size: int) -> int:
    """Number of states in a block; each takes `size` bytes."""
    return int(np.clip(BLOCK // max(size, 1), 1, MOST_STATES))
