# SPDX-License-Identifier: LGPL-3.0-or-later
"""Processes that read geometry and mesh files, split off one that has imported what they need.

fretfe starts a Python for each file, which imports for longer than it reads a file of a test.
Hundreds are read. tests/system/test_contained.py and others start processes as fretfe does.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import IO, Any

# Of a message: a folder to work in and the present one.
LENGTH = 8192


class Child:
    """A process as `subprocess.Popen` gives it, as far as fretfe.mesh.contained uses it."""

    def __init__(self, server: socket.socket, folder: str, messages: IO[bytes]) -> None:
        self._server = server
        # It ends when this process, which alone can write into the pipe, ends.
        end, self._stdin = os.pipe()
        words = [f"{folder}\0{os.getcwd()}".encode()]
        socket.send_fds(server, words, [end, messages.fileno()])
        os.close(end)
        self.pid = int(server.recv(LENGTH))
        self.returncode: int | None = None

    def wait(self, timeout: float | None = None) -> int:
        """The exit code; raises an error if the process takes longer than these seconds."""
        if self.returncode is None:
            self._server.settimeout(timeout)
            try:
                self.returncode = int(self._server.recv(LENGTH))
            except TimeoutError:
                raise subprocess.TimeoutExpired("mesh", timeout or 0.0) from None
            finally:
                self._server.settimeout(None)
        return self.returncode

    def kill(self) -> None:
        if self.returncode is None:
            os.kill(self.pid, 9)

    def __enter__(self) -> Child:
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._stdin)
        self.wait()


@contextmanager
def mesh_server() -> Iterator[SimpleNamespace]:
    """What fretfe.mesh.contained uses of `subprocess`, with processes of a server."""
    from fretfe.environment import without_launcher

    ours, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    command = [sys.executable, "-P", __file__, str(its.fileno())]
    with ours:
        with its:
            server = subprocess.Popen(
                command, pass_fds=[its.fileno()], env=without_launcher(os.environ)
            )

        def start(command: list[str], *, stdout: IO[bytes], **_: object) -> Child:
            return Child(ours, command[-1], stdout)

        try:
            yield SimpleNamespace(
                Popen=start, PIPE=subprocess.PIPE, TimeoutExpired=subprocess.TimeoutExpired
            )
        finally:
            ours.close()
            server.wait(60)


def serve(connection: socket.socket, main: Callable[[Path], Any]) -> None:
    """Split off one process after the other, until the process that asks for them ends."""
    while True:
        words, files, _, _ = socket.recv_fds(connection, LENGTH, 2)
        if not words:
            return
        process = os.fork()
        if process == 0:
            connection.close()
            _work(words.decode(), files, main)
        for each in files:
            os.close(each)
        connection.send(str(process).encode())
        _, status = os.waitpid(process, 0)
        connection.send(str(os.waitstatus_to_exitcode(status)).encode())


def _work(words: str, files: list[int], main: Callable[[Path], Any]) -> None:
    """What the process does that was split off; it does not return."""
    folder, here = words.split("\0")
    os.setsid()
    os.chdir(here)
    for target, file in zip((0, 1, 2), (files[0], files[1], files[1]), strict=True):
        os.dup2(file, target)
    code = 0
    try:
        main(Path(folder))
    except BaseException:
        traceback.print_exc()
        code = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


if __name__ == "__main__":
    import gmsh  # noqa: F401
    import h5py  # noqa: F401

    import fretfe.mesh.contained
    import fretfe.mesh.load

    with closing(socket.socket(fileno=int(sys.argv[1]))) as asked:
        serve(asked, fretfe.mesh.contained.main)
