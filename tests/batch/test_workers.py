"""Two workers on loopback, one killed in the middle: the answer of one process, to the last bit."""

import json
import signal
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager
from dataclasses import replace

import numpy as np
import pytest

import zoh
from zoh.batch import backend, workers
from zoh.batch.backend import SINGLE
from zoh.batch.blocks import Plan
from zoh.batch.job import Job
from zoh.batch.space import Random, Rows
from zoh.batch.spread import Uniform
from zoh.batch.stream import sweep_to
from zoh.batch.sweep import sweep_of, sweep_summary
from zoh.batch.workers import connected

distributed = pytest.importorskip("distributed")

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
JOB = Job(plant=ARM, law="pi", asked={"pm_deg": 40}, dt=0.1, varying=("wc",))
ASKED = zoh.Requirements(ms=1.8)


def space(count):
    return Random(spreads={"wc": Uniform(low=0.2, high=1.6)}, count=count, seed=2)


@contextmanager
def process(*command):
    """Run a process of our own; kill it at the end, if it still runs."""
    child = subprocess.Popen(
        [sys.executable, "-m", *command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        yield child
    finally:
        child.kill()
        child.wait()


@pytest.fixture
def cluster(tmp_path):
    """Return (client, processes): two workers of one thread each, on loopback."""
    file, quiet = tmp_path / "scheduler.json", ("--no-dashboard", "--host", "127.0.0.1")
    with ExitStack() as stack:
        stack.enter_context(
            process(
                "distributed.cli.dask_scheduler",
                "--port",
                "0",
                "--scheduler-file",
                str(file),
                *quiet,
            )
        )
        deadline = time.monotonic() + 60
        while not file.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        address = json.loads(file.read_text())["address"]
        processes = [
            stack.enter_context(
                process("distributed.cli.dask_worker", address, "--nthreads", "1", "--no-nanny",
                        "--local-directory", str(tmp_path / str(i)), *quiet)
            )
            for i in range(2)
        ]  # fmt: skip
        client = stack.enter_context(connected(address))
        client.wait_for_workers(2, timeout=60)
        yield client, processes


def test_a_worker_that_is_killed_changes_nothing(cluster, tmp_path):
    client, processes = cluster
    alone = sweep_summary(JOB, space(400), requirements=ASKED, block=20)
    killed = []

    def kill_one(done, loops):
        if done >= 100 and not killed:
            processes[0].send_signal(signal.SIGKILL)
            killed.append(done)

    spread = sweep_summary(
        JOB, space(400), requirements=ASKED, block=20, client=client, progress=kill_one
    )
    assert killed
    assert killed[0] < 400
    assert len(client.nthreads()) == 1  # one was really lost
    assert spread == alone
    path = str(tmp_path / "a.zarr")
    assert sweep_to(path, JOB, space(400), requirements=ASKED, block=100, client=client) == alone


def test_columns_come_back_in_their_order_whatever_is_done_first(monkeypatch):
    def backwards(function, tasks, client=None):
        return reversed([(task, function(task)) for task in tasks])

    values = {"wc": np.linspace(0.2, 1.6, 10)}
    job = Job(plant=ARM, law="pi", asked={"pm_deg": 40}, dt=0.1, varying=("wc",))
    monkeypatch.setattr(backend, "WAYS", (replace(SINGLE, block=4),))
    forwards = sweep_of(job, Rows(values=values))
    monkeypatch.setattr(workers, "each", backwards)
    found = sweep_of(job, Rows(values=values))
    for name in ("wc", "ms", "reason", "gains.kp"):
        assert np.array_equal(found[name], forwards[name], equal_nan=True)


def test_what_is_sent_does_not_grow_with_the_block():
    def sent(block):
        plan = Plan(job=JOB, space=space(10**9), arithmetic="single", block=block)
        return len(distributed.protocol.pickle.dumps(plan.task(3)))

    assert sent(10**6) == pytest.approx(sent(100), abs=16)  # digits of two numbers
    assert sent(10**6) < 4000
    rows = Plan(job=JOB, space=Rows(values={"wc": np.ones(10_000)}), arithmetic="single", block=10)
    assert len(distributed.protocol.pickle.dumps(rows.task(3))) < 4000  # only its own rows


def test_a_worker_with_another_version_is_refused():
    task = Plan(job=JOB, space=space(10), arithmetic="single", block=5).task(1)
    assert task.done().start == 5
    with pytest.raises(zoh.SpecError, match=r"client must have zoh 0.0.1, numpy 1 on every worker"):
        replace(task, told_by="zoh 0.0.1, numpy 1").done()


@pytest.mark.parametrize("client", ["tcp://127.0.0.1:8786", 3, object()])
def test_what_is_no_client_is_refused_before_the_work(client, tmp_path):
    path = tmp_path / "a.zarr"
    for ask in (
        lambda: zoh.sweep(ARM, "pi", {"pm_deg": 40}, dt=0.1, over={"wc": [0.5]}, client=client),
        lambda: sweep_summary(JOB, space(4), client=client),
        lambda: sweep_to(str(path), JOB, space(4), client=client),
    ):
        with pytest.raises(zoh.SpecError, match=r"client must be a dask.distributed.Client, got "):
            ask()
    assert not path.exists()


def test_a_client_that_is_closed_is_refused(cluster):
    client, _ = cluster
    client.close()
    with pytest.raises(zoh.SpecError, match="client must be connected, and not asynchronous"):
        sweep_summary(JOB, space(4), client=client)


def test_no_scheduler_is_said_in_one_line():
    with pytest.raises(zoh.SpecError, match="scheduler must answer at its address"):
        connected("tcp://127.0.0.1:9")
