"""A bar on standard error that says where a proof is; nothing where nobody watches."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from zoh.firmware.equality import Equality
from zoh.firmware.plan import Plan


@contextmanager
def proving(wanted: bool) -> Iterator[Callable[[Plan], Equality] | None]:
    """Yield what proves a plan while a bar shows how far it is; None where nothing is to be."""
    if not wanted:
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    from zoh.firmware.prove import prove

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    console = Console(stderr=True)
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:

        def proved(made: Plan) -> Equality:
            task = bar.add_task(f"{made.name}: the first build", total=None)

            def show(done: int, total: int, build: str) -> None:
                bar.update(task, completed=done, total=total, description=f"{made.name}: {build}")

            return prove(made, progress=show)

        yield proved
