"""How do commands of pages start without importing the package each time? One process imports it and forks for each.

``with started()`` puts the programs of this Python first on the path, and before them a `sits-mech` that sends its
words, its folder, its environment and its three streams to the process; a fork of that runs the command line's own
`main` with them, and `sits-mech` ends with its exit code. All else is as if the command was started by itself.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from typing import Any

_MORE = ("dask.array", "matplotlib.backends.backend_agg", "matplotlib.backends.backend_svg", "pandas", "scipy.optimize")
_SENDS = """#!{python} -IS
import json, os, socket, sys
with socket.socket(socket.AF_UNIX) as line:
    line.connect({path!r})
    socket.send_fds(line, [b"x"], [0, 1, 2])
    line.sendall(json.dumps([sys.argv[1:], os.getcwd(), dict(os.environ)]).encode())
    line.shutdown(socket.SHUT_WR)
    sys.exit((line.recv(1) or b"\\1")[0])
"""


@contextlib.contextmanager
def started() -> Iterator[None]:
    """Have `sits-mech` answered by a process that ends with this."""
    with tempfile.TemporaryDirectory() as place:
        command, path = Path(place) / "sits-mech", str(Path(place) / "line")
        command.write_text(_SENDS.format(python=sys.executable, path=path), encoding="utf-8")
        command.chmod(0o755)
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(path)
            listener.listen()
            words = [sys.executable, __file__, str(listener.fileno())]
            before = os.environ["PATH"]
            with subprocess.Popen(words, pass_fds=[listener.fileno()], stdin=subprocess.DEVNULL) as process:
                os.environ["PATH"] = os.pathsep.join((place, str(Path(sys.executable).parent), before))
                try:
                    yield
                finally:
                    os.environ["PATH"] = before
                    process.terminate()


def answer(listener: socket.socket) -> None:
    """Import what commands do, and fork for each that comes."""
    import sits_mech

    for name in (*(each.name for each in walk_packages(sits_mech.__path__, "sits_mech.")), *_MORE):
        if not name.endswith("__main__"):
            with contextlib.suppress(ImportError):  # an extra that is not installed
                import_module(name)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    while True:
        line, _ = listener.accept()
        if os.fork() == 0:
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            listener.close()
            _run(line)
        line.close()


def _run(line: socket.socket) -> None:
    """Run the command that a line asks for, tell its exit code, and end."""
    code: Any = 1
    try:
        _, streams, _, _ = socket.recv_fds(line, 1, 3)
        with line.makefile("rb") as stream:
            words, folder, environment = json.load(stream)
        for own, stream_of_command in enumerate(streams):
            os.dup2(stream_of_command, own)
            os.close(stream_of_command)
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(environment)
        sys.argv = ["sits-mech", *words]
        from sits_mech.cli.main import main

        main()
    except SystemExit as end:
        code = end.code
    finally:
        for written in (sys.stdout, sys.stderr):
            written.flush()
        line.sendall(bytes([code if isinstance(code, int) else int(code is not None)]))
        os._exit(0)


if __name__ == "__main__":
    answer(socket.socket(fileno=int(sys.argv[1])))
