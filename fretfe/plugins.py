# SPDX-License-Identifier: LGPL-3.0-or-later
"""Objects and files that other packages bring by entry points, by groups of them.

One that cannot be loaded, or raises, is named with its package.
"""

from __future__ import annotations

import reprlib
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

from fretfe.environment import memory_shortage, missing_package
from fretfe.errors import DependencyError, FretfeError, MemoryShortError
from fretfe.libraries import elsewhere

# Groups: functions that return the path of a material file, or of a template, by its name;
# functions that give factors of a traction at places; functions that make a section of the report
# from a result.
LOAD_FUNCTIONS = "fretfe.loads"
MATERIALS = "fretfe.materials"
TEMPLATES = "fretfe.templates"
SECTIONS = "fretfe.sections"


@dataclass(frozen=True)
class PlugIn:
    """An object of a package.

    Attributes:
        name: by which it is chosen.
        package: name and version of the package that brings it.
        entry: its entry point.
    """

    name: str
    package: str
    entry: EntryPoint

    @property
    def title(self) -> str:
        """Name and package, for messages."""
        return f"{self.name!r} of {self.package}"

    @property
    def file(self) -> Path | None:
        """The file of its module; None without one, or if it cannot be imported."""
        self.load()
        file = getattr(sys.modules.get(self.entry.module), "__file__", None)
        return Path(file) if file else None

    def load(self) -> tuple[Any, str]:
        """The object; or None, and why it cannot be loaded."""
        try:
            with elsewhere():  # it may load libraries
                return self.entry.load(), ""
        except (Exception, SystemExit) as error:  # what foreign modules raise is not ours to know
            if isinstance(error, MemoryShortError):
                raise
            if shortage := memory_shortage(error):
                raise MemoryShortError(shortage) from error
            return None, missing_package(error) or str(error) or type(error).__name__

    def call(self, *arguments: Any) -> Any:
        """Call the object.

        Raises:
            DependencyError: if it cannot be loaded, or raises what is no error of fretfe.
        """
        function, reason = self.load()
        if reason:
            raise DependencyError(f"{self.title} cannot be used: {reason}")
        return self.guard(function, *arguments)

    def guard(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a function that is the object, or that it has returned; raises as `call`."""
        try:
            return function(*arguments)
        except FretfeError:
            raise
        except Exception as error:
            if shortage := memory_shortage(error):
                raise MemoryShortError(shortage) from error
            text = f"{type(error).__name__}: {error}"
            raise DependencyError(f"{self.title} failed: {text}") from error


def what(value: object) -> str:
    """A value in place of what a plug-in should return: of an array its shape and kind."""
    if not hasattr(value, "shape"):
        return reprlib.repr(value)
    import numpy as np

    array = np.asarray(value)
    lost = int(np.sum(~np.isfinite(array))) if array.dtype.kind in "fc" else 0
    more = f", of which {lost} are not finite" if lost else ""
    return f"an array of the shape {array.shape} of {array.dtype}{more}"


def plug_ins(group: str, own: Sequence[str] = ()) -> list[PlugIn]:
    """All of a group, in the order in which a name is given away: fretfe, then by name.

    Args:
        group: of entry points, such as ``fretfe.backends``.
        own: names of those of fretfe, in their order.
    """

    def order(entry: EntryPoint) -> tuple[bool, int, str, str]:
        mine = entry.dist is not None and entry.dist.name == "fretfe"
        place = own.index(entry.name) if mine and entry.name in own else len(own)
        return not mine, place, entry.name, _package(entry)

    entries = sorted(entry_points(group=group), key=order)
    return [PlugIn(entry.name, _package(entry), entry) for entry in entries]


def plug_in(group: str, name: str) -> PlugIn | None:
    """The one of this name in a group; None without one."""
    return next((each for each in plug_ins(group) if each.name == name), None)


def plugged_file(group: str, name: str) -> Path | None:
    """The file that a function of a group returns, by its name; None without one.

    Raises:
        DependencyError: if the function cannot be used, or gives no file.
    """
    found = plug_in(group, name)
    if found is None:
        return None
    path = found.call()
    if not isinstance(path, Path) or not path.is_file():
        raise DependencyError(f"{found.title}: expected the Path of a file, found {what(path)}")
    return path


def _package(entry: EntryPoint) -> str:
    return f"{entry.dist.name} {entry.dist.version}" if entry.dist else ""
