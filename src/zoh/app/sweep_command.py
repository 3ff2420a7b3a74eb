"""The terminal of ``zoh sweep``: its progress bar, and the way to its workers."""

import sys
from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from zoh.app import files
from zoh.app.over import read_over
from zoh.app.project import read
from zoh.app.sweep import Options, Swept, sweep_all
from zoh.batch.workers import Progress, connected


def swept(arguments: Namespace) -> tuple[Swept, ...]:
    """Return what the arguments ask for; say the progress on a terminal."""
    project = read(files.read_text(arguments.file), files.beside(arguments.file))
    space = read_over(
        arguments.over, sample=arguments.sample, seed=arguments.seed, latin=arguments.latin,
        ends=arguments.corners,
    )  # fmt: skip
    client = None if arguments.scheduler is None else connected(arguments.scheduler)
    options = Options(
        out=arguments.out, arithmetic=arguments.arithmetic, client=client, fixed=arguments.fixed,
        held=arguments.figures is not None,
    )  # fmt: skip
    try:
        with _bars() as watched:
            return sweep_all(project, space, arguments.controller, options, watched)
    finally:
        if client is not None:
            client.close()


@contextmanager
def _bars() -> Iterator[Callable[[str], Progress | None]]:
    """Yield a function that starts a bar with the rate and the time left; none off a terminal."""
    if not sys.stderr.isatty():
        yield lambda name: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:

        def start(name: str) -> Any:
            task = bars.add_task(name, total=None, rate="")

            def told(done: int, loops: int) -> None:
                bars.update(task, completed=done, total=loops)
                speed = bars.tasks[task].speed
                bars.update(task, rate="" if speed is None else f"{speed:,.0f} loops/s")

            return told

        yield start
