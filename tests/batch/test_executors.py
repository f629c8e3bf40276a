"""Studies on processes and clusters: workers that are killed, stopped, slow, too small, or of another version."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import sits_mech as sm
from sits_mech.batch.executors import _alone, _check_versions, cluster_size, workers
from sits_mech.cli.main import run
from sits_mech.units import SceneError
from sits_mech.version import __version__

STUDY = """
scene = "biorob2018"
request = "inductance"
[vary]
"target.width" = ["8 mm", "9 mm"]
dv = {{ from = "1 mm", to = "4 mm", count = {} }}
[fixed]
model = "planar"
tolerance = 1e-2
"""


def written(folder: Path, count: int = 2) -> Path:
    """Return the path of a study with so many gaps of two targets."""
    path = folder / "study.toml"
    path.write_text(STUDY.format(count))
    return path


@contextmanager
def cluster(workers: int, threads: int = 1, settings: dict[str, Any] | None = None, **more: Any) -> Iterator[Any]:
    """Give a cluster of processes on this machine; the port of its page is any free one, for others may run here."""
    distributed, dask = pytest.importorskip("distributed"), pytest.importorskip("dask")
    quiet = {"dashboard_address": ":0", "silence_logs": 50, "processes": True}
    settings = {"deploy.lost-worker-timeout": "60s"} | (settings or {})  # a machine that is busy begins them slowly
    with (
        dask.config.set({f"distributed.{name}": item for name, item in settings.items()}),
        distributed.LocalCluster(n_workers=workers, threads_per_worker=threads, **quiet, **more) as found,
    ):
        yield found


def test_versions_of_workers_are_named() -> None:
    """Each other version once with its first worker; one that was lost since is none of them."""
    _check_versions({"tcp://a:1": __version__, "tcp://b:1": OSError("gone")})
    found = {"tcp://a:1": "0.1.0", "tcp://a:2": __version__, "tcp://b:1": None, "tcp://c:1": "0.1.0"}
    message = f"must have sits_mech {__version__}, as this process has; got 0.1.0 on tcp://a:1 and 1 more; none on tcp://b"
    with pytest.raises(SceneError, match=message):
        _check_versions(found)
    with pytest.raises(SceneError, match=r"must have sits_mech 0\.1\.0, as the client has; .* has "):
        _alone("0.1.0", int)


@pytest.mark.slow
def test_a_client_in_this_process(tmp_path: Path) -> None:
    """It stays open; what it runs is what one process gives."""
    distributed = pytest.importorskip("distributed")
    path = written(tmp_path)
    with distributed.Client(processes=False, n_workers=1, threads_per_worker=2, dashboard_address=":0") as client:
        data = sm.sweep(path, folder=tmp_path / "out", executor=client)
        assert client.submit(int, "7").result() == 7
        found = sm.sweep(lambda a: {"b": 2.0 * a}, {"a": [1.0, 2.0]}, executor=client)
    assert found["b"].values.tolist() == [2.0, 4.0]
    xr.testing.assert_identical(
        data.drop_vars("seconds"), sm.sweep(path, folder=tmp_path / "alone").drop_vars("seconds")
    )


@pytest.mark.slow
def test_no_cluster_at_an_address(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line that names the address, for a run and for a plan."""
    pytest.importorskip("distributed")
    monkeypatch.setattr("sits_mech.batch.executors._ANSWER_TIMEOUT", 1)
    command = ["sweep", str(written(tmp_path)), "-o", str(tmp_path / "out"), "--dask", "tcp://127.0.0.1:1"]
    for more in ([], ["--plan"]):
        assert run([*command, *more]) == 2
        assert "tcp://127.0.0.1:1" in capsys.readouterr().err and not (tmp_path / "out").exists()


@pytest.mark.slow
def test_workers_that_are_killed_stopped_and_slow(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is lost, nothing waits for ever, and every digit is that of one process; two threads in each.

    Workers keep what they prepare in the user's cache folder, as the command line does.
    """
    from distributed import Client

    monkeypatch.delenv("SITS_MECH_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    path, done_at = written(tmp_path, 400), []
    with cluster(4, 2, {"scheduler.worker-ttl": "30s"}) as found, Client(found) as client:  # imports may take 15 s
        killed, stopped, slow, _ = (worker.pid for worker in found.workers.values())
        os.setpriority(os.PRIO_PROCESS, slow, 19)

        def disturb(done: int, total: int) -> None:
            done_at.append(time.monotonic())
            if len(done_at) == total // 8:
                os.kill(stopped, signal.SIGSTOP)
            if len(done_at) == total // 4:
                os.kill(killed, signal.SIGKILL)

        try:
            data = sm.sweep(path, folder=tmp_path / "out", executor=client, progress=disturb)
            assert str(tmp_path / "cache" / "sits-mech") in client.run(os.getenv, "SITS_MECH_CACHE").values()
        finally:
            with suppress(ProcessLookupError):
                os.kill(stopped, signal.SIGCONT)
    assert len(done_at) == 800 and np.diff(done_at).max() > 10.0  # until the stopped one was given up
    alone = sm.sweep(path, folder=tmp_path / "alone")
    xr.testing.assert_identical(data.drop_vars("seconds"), alone.drop_vars("seconds"))


def greedy(size: int) -> dict[str, float]:
    """Hold some MB for a while."""
    held = np.ones(size * 125_000)
    time.sleep(2.0)
    return {"held": float(held.size)}


@pytest.mark.slow
def test_a_case_that_no_worker_can_hold(tmp_path: Path) -> None:
    """It is a row that says so, and the others are finished; with more memory the same sweep gives it."""
    from distributed import Client

    grid, kept = {"size": [1, 2, 1000, 3]}, {"folder": tmp_path, "chunk": 2}
    with cluster(2, settings={"scheduler.allowed-failures": 0}, memory_limit="600MB") as found, Client(found) as client:
        data = sm.sweep(greedy, grid, executor=client, **kept)
    assert data["status"].values.tolist() == ["ok", "ok", "failed", "ok"]
    assert "each worker that it ran on was lost" in data["reason"][2].item()
    calls = []

    def counted(size: int) -> dict[str, float]:
        calls.append(size)
        return greedy(size)

    assert set(sm.sweep(counted, grid, **kept)["status"].values) == {"ok"} and calls == [1000]


def hoard(number: int) -> dict[str, float]:
    """Let a worker hold 0.9 of its 600 MB: above where dask pauses one, below where it ends one."""
    import psutil

    if not hasattr(sys, "held"):
        sys.held = np.ones(int(540e6 - psutil.Process().memory_info().rss) // 8)
    time.sleep(0.5)  # some looks at the memory
    return {"twice": 2.0 * number}


@pytest.mark.slow
def test_workers_that_are_nearly_full_go_on() -> None:
    """What they hold are models, which no waiting frees."""
    from distributed import Client

    with cluster(2, memory_limit="600MB") as found, Client(found) as client:
        data = sm.sweep(hoard, {"number": list(range(8))}, executor=client)
    assert data["twice"].values.tolist() == [0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0]


@pytest.mark.slow
def test_workers_of_another_version(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One line, nothing touched; a plan is for the workers that there are."""
    (tmp_path / "old" / "sits_mech").mkdir(parents=True)
    (tmp_path / "old" / "sits_mech" / "__init__.py").write_text('__version__ = "0.1.0"')
    path = written(tmp_path)
    with cluster(0) as found:
        address = found.scheduler_address
        with pytest.raises(SceneError, match="must have workers"):
            cluster_size(address)
        command = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--no-dashboard", "--nthreads", "1"]
        environment = os.environ | {"PYTHONPATH": str(tmp_path / "old")}
        old = subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL, cwd=tmp_path)
        try:
            for _ in range(300):
                if found.scheduler.workers:
                    break
                time.sleep(0.1)
            assert run(["sweep", str(path), "-o", str(tmp_path / "out"), "--dask", address]) == 2
            shown = capsys.readouterr()
            assert shown.out == "" and shown.err.strip().splitlines()[-1].startswith("error: dask: workers must have")
            assert "got 0.1.0 on tcp://" in shown.err and not (tmp_path / "out").exists()
            assert run(["sweep", str(path), "--plan", "--dask", address]) == 0
            assert "on 1 workers" in capsys.readouterr().out
        finally:
            old.terminate()
            old.wait()


@pytest.mark.slow
def test_a_process_that_is_killed(tmp_path: Path) -> None:
    """One line; what is finished is kept, and the same command goes on."""
    path, out = written(tmp_path, 200), tmp_path / "out"
    (tmp_path / "killed.py").write_text(KILLED)
    words = [sys.executable, str(tmp_path / "killed.py"), str(path), str(out)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=600)
    assert done.stdout == "" and done.stderr.count("\n") == 1 and "those that are kept stay" in done.stderr
    kept = []
    data = sm.sweep(path, folder=out, progress=lambda done, of: kept.append(done))
    assert set(data["status"].values.ravel()) == {"above tolerance"}  # all answered; bars leave out the ends
    assert (data["seconds"] > 0.0).all()


KILLED = """
import os, signal, sys
from multiprocessing import active_children
from pathlib import Path
from sits_mech.batch.executors import workers
from sits_mech.batch.sweep import sweep

def end(done, of):
    if done == 50:
        os.kill(active_children()[0].pid, signal.SIGKILL)

if __name__ == "__main__":
    with workers(2) as executor:
        try:
            sweep(sys.argv[1], folder=sys.argv[2], executor=executor, progress=end)
        except ValueError as error:
            print(error, file=sys.stderr)
"""


SLOW = """
import multiprocessing, pathlib, time
if multiprocessing.parent_process() is not None:
    pathlib.Path(__file__).with_name("begun").touch()
    time.sleep(300)

def case():
    pass
"""
ENDED = """
import os, pathlib, signal, sys, time
from multiprocessing import active_children
from sits_mech.batch.executors import workers

if __name__ == "__main__":
    from slow import case  # by workers with the call
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with workers(2) as executor:
            found = [executor.submit(case) for _ in range(9)]
            while not pathlib.Path(__file__).with_name("begun").exists():
                time.sleep(0.01)
            try:
                os.killpg(0, int(sys.argv[1]))
                found[0].result()
            finally:
                for each in found:
                    each.cancel()  # as a sweep does
    except KeyboardInterrupt:
        print("interrupted", len(active_children()))
"""


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_an_end_of_all_processes_is_that_of_one(tmp_path: Path, ending: signal.Signals) -> None:
    """Of Ctrl-C and schedulers, who signal workers too: these say nothing, wait for no case and are gone."""
    (tmp_path / "slow.py").write_text(SLOW)
    (tmp_path / "ended.py").write_text(ENDED)
    done = subprocess.run(
        [sys.executable, str(tmp_path / "ended.py"), str(int(ending))], capture_output=True, text=True, timeout=60,
        start_new_session=True, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert (done.stdout, done.stderr, done.returncode) == ("interrupted 0\n", "", 0)


LOST = """
import multiprocessing, os, pathlib, signal, sys, time
from concurrent.futures import BrokenExecutor
from sits_mech.batch.executors import workers

def case(k):
    pathlib.Path(__file__).with_name(f"begun{os.getpid()}").touch()
    time.sleep(100)

if __name__ == "__main__":
    other = multiprocessing.get_context("spawn").Process(target=time.sleep, args=(100,))
    other.start()
    try:
        with workers(2) as executor:
            found = executor.submit(case, 1), executor.submit(case, 2)
            while len(begun := [*pathlib.Path(__file__).parent.glob("begun*")]) < 2:
                time.sleep(0.01)
            os.kill(int(begun[0].name[5:]), signal.SIGKILL)
            began = time.monotonic()
            if sys.argv[1] == "raised":
                found[1].result()
            found[1].exception()
    except BrokenExecutor:
        assert sys.argv[1] == "raised"
    print(time.monotonic() - began < 2.0, multiprocessing.active_children() == [other], other.is_alive())
    other.kill()
"""


@pytest.mark.parametrize("way", ["raised", "caught"])
def test_a_lost_worker_ends_its_pool_at_once(tmp_path: Path, way: str) -> None:
    """The other worker's case is not waited for; processes of the caller's own live on."""
    (tmp_path / "lost.py").write_text(LOST)
    words = [sys.executable, str(tmp_path / "lost.py"), way]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert (done.stdout, done.stderr) == ("True True True\n", "")


def test_signals_are_held_back_only_where_they_were() -> None:
    """Of the caller they stay as they were; workers hold none back that they leave to what they start."""
    resource_tracker.ensure_running()  # which lets signals in when it is started
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGTERM])
    try:
        with workers(2) as executor:
            own = executor.submit(signal.pthread_sigmask, signal.SIG_BLOCK, []).result()
            assert not own & {signal.SIGINT, signal.SIGTERM}
        assert signal.SIGTERM in signal.pthread_sigmask(signal.SIG_BLOCK, [])
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


PROBE = """
def threads():
    import numpy, scipy.linalg, threadpoolctl
    return [library["num_threads"] for library in threadpoolctl.threadpool_info()]

if __name__ == "__main__":
    from sits_mech.batch.executors import workers
    with workers(2) as executor:
        print(*executor.submit(threads).result())
"""


def test_a_worker_keeps_to_one_thread(tmp_path: Path) -> None:
    """Also of libraries that come after it was started; the environment here asks for two."""
    path = tmp_path / "probe.py"
    path.write_text(PROBE)
    asked = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "2")
    words = [sys.executable, str(path)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=True, env=os.environ | asked)
    assert set(done.stdout.split()) == {"1"}
