"""What a Dask worker more is worth, and what the scheduler takes for itself.

The same sweep is summarised here, and then by 1, 2, ... worker processes of one thread on
loopback. Printed: the rate, the speed beside one worker's, the loops that each worker had, whether
the answer is the same to the last bit, and the scheduler's share: what a task costs of which
nothing is asked, against the time of one block.

    python -m benchmarks.sweep.scale --loops 4194304 --block 262144 --workers 2

exits 1 where an answer differs.
"""

import argparse
import sys
import time

from benchmarks.sweep.memory import JOB, SPREADS
from distributed import Client, LocalCluster

import zoh
from zoh.batch.blocks import Task
from zoh.batch.sweep import plan_of
from zoh.batch.workers import each

WARM = 1  # sweeps before the one that is timed: imports and compilation


def nothing(task: Task) -> int:
    return task.number


def empty_task_s(client: Client, plan: zoh.batch.blocks.Plan, times: int = 20) -> float:
    """Return the seconds of a task of which nothing is asked, over so many plans."""
    begun = time.perf_counter()
    for _ in range(times):
        list(each(nothing, plan, client))
    return (time.perf_counter() - begun) / (times * len(plan))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--loops", type=int, default=8192)
    parser.add_argument("--block", type=int, default=512)
    parser.add_argument("--arithmetic")
    parser.add_argument("--workers", type=int, default=2, help="the most that are tried")
    asked = parser.parse_args()
    space = zoh.Random(spreads=SPREADS, count=asked.loops, seed=1)

    def swept(client: Client | None) -> tuple[zoh.Summary, float]:
        for _ in range(WARM + 1):
            begun = time.perf_counter()
            found = zoh.sweep_summary(
                JOB, space, arithmetic=asked.arithmetic, block=asked.block, client=client
            )
            seconds = time.perf_counter() - begun
        return found, seconds

    alone, seconds = swept(None)
    print(f"one process        {asked.loops / seconds:>10.0f} loops/s")
    plan, same, first = plan_of(JOB, space, asked.arithmetic, asked.block), True, 0.0
    for n in range(1, asked.workers + 1):
        with (
            LocalCluster(
                n_workers=n, threads_per_worker=1, processes=True, dashboard_address=None
            ) as cluster,
            Client(cluster) as client,
        ):
            found, seconds = swept(client)
            first, same = first or seconds, same and found == alone
            share = empty_task_s(client, plan) * len(plan) / seconds
        print(
            f"{n} worker{'s' if n > 1 else ' '}          {asked.loops / seconds:>10.0f} loops/s"
            f"  {first / seconds:.2f} times one  {asked.loops / n:.0f} loops each"
            f"  scheduler {100 * share:.2f} %  same bits: {found == alone}",
            flush=True,
        )
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
