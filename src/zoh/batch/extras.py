"""Packages that only some uses of a sweep need: imported where they are used, or one line."""

from importlib import import_module
from typing import Any

from zoh.errors import SpecError


def needed(module: str, what: str) -> Any:
    """Return the module; raise SpecError, with the way to get it, where it is not installed.

    >>> needed("no_such_package", "a figure")
    Traceback (most recent call last):
    zoh.errors.SpecError: a figure must have no_such_package, got None: pip install 'zoh[fast]'...
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as absent:
        package = module.partition(".")[0]
        if (absent.name or "").partition(".")[0] != package:
            raise
    raise SpecError(what, f"must have {package}", None, "pip install 'zoh[fast]' brings it")
