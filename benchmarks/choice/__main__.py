"""Every choice of random tasks is attacked.

    python -m benchmarks.choice --plants 50 --tries 4000

prints what beats a choice by more than 0.1 %, and exits 1 where anything does.
"""

import argparse
import sys
from random import Random

from benchmarks.choice.attack import beaten, drawn, gridded

import zoh


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plants", type=int, default=50)
    parser.add_argument("--tries", type=int, default=4000)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    losses = chosen = refused = 0
    for i in range(arguments.plants):
        random = Random(arguments.seed * 100_003 + i)
        task = drawn(random)
        asked = task.asked
        try:
            found = zoh.design(task.plant, task.law, {}, dt=task.dt, requirements=asked)
        except zoh.Infeasible as why:
            refused += 1
            print(f"{i:3d} {task.law:5s} refused: {why}"[:160])
            continue
        chosen += 1
        grid = gridded(task, found)
        rival = beaten(task, found, found.requirements, random, arguments.tries, grid)
        text = f"{i:3d} {task.law:5s} {found.margins.crossover:.6g} rad/s"
        if rival is not None:
            losses += 1
            share = rival.margins.crossover / found.margins.crossover - 1
            text += f" BEATEN by {100 * share:.2f} %: {rival.controller.num_w}"
            text += f" over {rival.controller.den_w} in w"
        print(text, flush=True)
    print(f"{chosen} choices, {losses} beaten by more than 0.1 %, {refused} refused")
    return 1 if losses else 0


if __name__ == "__main__":
    sys.exit(main())
