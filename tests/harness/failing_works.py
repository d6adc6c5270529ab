# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stands for libraries that fail while they read a file, in the process that reads it."""

from __future__ import annotations

import os
import signal
import time

from fretfe.mesh.contained import Opened
from fretfe.mesh.gmsh import RawMesh


def abort(opened: Opened) -> RawMesh:
    os.abort()


def segmentation(opened: Opened) -> RawMesh:
    signal.raise_signal(signal.SIGSEGV)
    raise AssertionError


def leave(opened: Opened) -> RawMesh:
    os._exit(0)


def hang(opened: Opened) -> RawMesh:
    time.sleep(300)
    raise AssertionError


def hang_later(opened: Opened) -> RawMesh:
    """After reading, with a limit of its own, as of a field of another run."""
    opened(4.0)
    time.sleep(300)
    raise AssertionError


def eat(opened: Opened) -> RawMesh:
    held = b"x" * 10**15
    raise AssertionError(len(held))
