"""What a long search is at, shown while it lasts on a terminal and nowhere else."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from zoh.request import Progress


@contextmanager
def shown_progress() -> Iterator[Progress | None]:
    """Yield what shows a sentence on standard error, None where nobody looks."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console

    console = Console(stderr=True, highlight=False, markup=False)
    with console.status("") as status:
        yield status.update
