# SPDX-License-Identifier: LGPL-3.0-or-later
"""Arguments of Python functions, checked by the types that these are annotated with."""

from __future__ import annotations

import inspect
import reprlib
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from functools import wraps
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin

import numpy as np

F = TypeVar("F", bound=Callable[..., Any])
# Types that another one stands for in Python and in NumPy.
NUMBERS: dict[Any, tuple[type, ...]] = {
    int: (int, np.integer),
    float: (int, float, np.integer, np.floating),
    bool: (bool, np.bool_),
}

MAKERS = {"Case": ", as load_case gives it", "Result": ", as run or load_result gives it"}


def typed(function: F) -> F:
    """A function that names an argument of a wrong type, before it does anything.

    Raises:
        TypeError: says what was expected and found.
    """
    signature, known = inspect.signature(function), inspect.getmodule(function)

    @wraps(function)
    def checked(*arguments: Any, **more: Any) -> Any:
        for name, value in signature.bind(*arguments, **more).arguments.items():
            annotation = signature.parameters[name].annotation
            if not fits(value, _kind(annotation, vars(known))):
                raise TypeError(
                    f"{function.__name__}: {name}: expected {annotation}"
                    f"{MAKERS.get(annotation, '')}, found {reprlib.repr(value)}"
                )
        return function(*arguments, **more)

    return checked  # type: ignore[return-value]


def _kind(annotation: str, names: Mapping[str, Any]) -> Any:
    """The type of an annotation; any where it is of a library that is not loaded for that."""
    try:
        return eval(annotation, dict(names))  # of fretfe itself
    except NameError:
        return Any


def fits(value: Any, kind: Any) -> bool:
    """True if a value is of a type of `typing`."""
    origin, inner = get_origin(kind), get_args(kind)
    if kind is Any:
        return True
    if origin in (Union, UnionType):
        return any(fits(value, each) for each in inner)
    if origin is Literal:
        return isinstance(value, Hashable) and value in inner
    if kind in NUMBERS:
        return isinstance(value, NUMBERS[kind]) and isinstance(value, bool) <= (kind is bool)
    if origin is tuple:
        return (
            isinstance(value, tuple | list)
            and len(value) == len(inner)
            and all(map(fits, value, inner))
        )
    if origin in (Sequence, Iterable):
        several = isinstance(value, Iterable) and not isinstance(value, str | bytes | Mapping)
        return several and (origin is Iterable or all(fits(each, inner[0]) for each in value))
    if origin is Mapping:
        return isinstance(value, Mapping) and all(fits(each, inner[1]) for each in value.values())
    # NumPy's type of arrays has a name for itself in some versions.
    named = get_origin(getattr(origin, "__value__", None)) or origin
    return isinstance(value, named or (NoneType if kind is None else kind))
