"""How do commands of pages start without importing the package each time? One process imports it and forks for each.

``with started()`` puts the programs of this Python first on the path, and before them a `sits-mech` and a `python` that
send their words, their folder, their environment and their three streams to the process; a fork of that runs the
command line's own `main`, or the file that Python is asked for, and they end with its exit code. All else is as if each
was started by itself; Python that is asked for no file is. What one prepares is kept for the others till the end.

``python docs/_ext/warm.py FOLDER`` puts the two programs there, `python` last, and answers till its input ends; where
SITS_DOCS_WARM names such a folder, `started` uses it.
"""

from __future__ import annotations

import contextlib
import gc
import json
import logging
import os
import runpy
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from typing import Any

_MORE = (
    "dask.array", "dask.distributed", "netCDF4", "matplotlib.backends.backend_agg",
    "matplotlib.backends.backend_svg", "matplotlib.figure", "pandas", "pint", "rich.live", "scipy.optimize",
)
_PROGRAMS = ("sits-mech", "python")
_SENDS = """#!{python} -IS
import json, os, signal, socket, sys
if {name!r} == "python" and not "".join(sys.argv[1:2]).endswith(".py"):
    os.execv({python!r}, [{python!r}, *sys.argv[1:]])
with socket.socket(socket.AF_UNIX) as line:
    line.connect({path!r})
    socket.send_fds(line, [b"x"], [0, 1, 2])
    line.sendall(json.dumps([[{name!r}, *sys.argv[1:]], os.getcwd(), dict(os.environ)]).encode())
    line.shutdown(socket.SHUT_WR)
    answering = int(line.recv(16) or b"0")
    for each in (signal.SIGINT, signal.SIGTERM):
        signal.signal(each, lambda number, _: answering and os.killpg(answering, number))
    sys.exit((line.recv(1) or b"\\1")[0])
"""


@contextlib.contextmanager
def started() -> Iterator[None]:
    """Have `sits-mech`, and files of Python, answered by the process of SITS_DOCS_WARM, or one that ends with this."""
    with contextlib.ExitStack() as ends:
        place = Path(os.environ.get("SITS_DOCS_WARM") or ends.enter_context(tempfile.TemporaryDirectory()))
        if "SITS_DOCS_WARM" not in os.environ:
            words = [sys.executable, __file__, str(place)]
            process = ends.enter_context(subprocess.Popen(words, stdin=subprocess.PIPE))
            while not os.access(place / _PROGRAMS[-1], os.X_OK) and process.poll() is None:
                time.sleep(0.01)
        before = dict(os.environ)
        os.environ["PATH"] = os.pathsep.join((str(place), str(Path(sys.executable).parent), before["PATH"]))
        os.environ["SITS_MECH_CACHE"] = str(place / "cache")
        try:
            yield
        finally:
            os.environ.clear()
            os.environ.update(before)


def answer(place: Path) -> None:
    """Put programs in a folder, import what commands do, and fork for each that comes."""
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(place / "line"))
        listener.listen(64)
        for name in _PROGRAMS:
            command, sent = place / name, {"python": sys.executable, "path": str(place / "line"), "name": name}
            command.write_text(_SENDS.format(**sent), encoding="utf-8")
            command.chmod(0o755)
        _prepare()
        signal.signal(signal.SIGCHLD, _ended)
        while sys.stdin not in select.select([listener, sys.stdin], [], [])[0]:
            line, _ = listener.accept()
            if os.fork() == 0:
                signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                listener.close()
                os.setpgid(0, 0)
                _run(line)
            line.close()


def _prepare() -> None:
    """Import what commands do, and fill what forks begin with."""
    import sits_mech

    for name in (*(each.name for each in walk_packages(sits_mech.__path__, "sits_mech.")), *_MORE):
        if not name.endswith("__main__"):
            with contextlib.suppress(ImportError):  # an extra that is not installed
                import_module(name)
    from sits_mech.report.pictures.style import figure_bytes, new_figure

    sensor, load = sits_mech.load_sensor("biorob2018"), sits_mech.Wrench(F_x=0.1, F_z=0.5)
    sits_mech.simulate(sensor, load, mechanics="planar", magnetics="planar", tolerance=0.1)
    fonts = logging.getLogger("matplotlib.font_manager")
    fonts.disabled = True  # it tells of fonts that are not there
    with new_figure() as (figure, (axes,)):
        axes.set(xlabel="$F_z$ [N]")  # in fonts of formulas, too
        figure_bytes(figure, "png")
    fonts.disabled = False
    gc.collect()
    gc.freeze()  # forks need not go through it again


def _ended(*_: object) -> None:
    """Let go of forks that have ended; their time is this process's."""
    with contextlib.suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass


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
        line.sendall(f"{os.getpid():16}".encode())
        code = _answered(words)
    except SystemExit as end:
        code = end.code
    except BaseException:
        traceback.print_exc()
    finally:
        for written in (sys.stdout, sys.stderr):
            written.flush()
        line.sendall(bytes([code if isinstance(code, int) else int(code is not None)]))
        os._exit(0)


def _answered(words: list[str]) -> int:
    """Run the command line, or a file of Python, and return the exit code of its end."""
    name, *words = words
    if name == "python":
        sys.argv = words
        path, more = Path(words[0]).resolve(), os.environ.get("PYTHONPATH", "").split(os.pathsep)
        sys.path[:1] = [str(path.parent), *filter(None, more)]
        runpy.run_path(str(path), run_name="__main__")
    else:
        sys.argv = [name, *words]
        from sits_mech.cli.main import main

        main()
    return 0


if __name__ == "__main__":
    answer(Path(sys.argv[1]))
