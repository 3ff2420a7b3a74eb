"""The only place that reads and writes files: nothing half-read, nothing half-written."""

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from zoh.app.toml import LONGEST
from zoh.errors import SpecError

_READABLE = "must be a project file that can be read"


def read_text(path: str, argument: str = "FILE", bound: str = _READABLE) -> str:
    """Return the text of a file, or raise SpecError with the reason in one line."""
    try:
        with open(path, "rb") as file:
            data = file.read(4 * LONGEST + 1)  # a device without an end stops here, too
    except (OSError, ValueError) as e:  # ValueError: a name that no file can have
        reason = e.strerror if isinstance(e, OSError) and e.strerror else str(e)
        raise SpecError(argument, bound, _end_of(path), reason.lower()) from None
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as e:
        way_out = f"save it as UTF-8 (byte {e.start} is none)"
        raise SpecError(argument, "must be UTF-8 text", _end_of(path), way_out) from None


def beside(project: str) -> Callable[[str], str]:
    """Return a function that reads a file in the folder of the project file, or below it."""

    def read(name: str) -> str:
        argument = "plant.frequency_response"
        if Path(name).is_absolute() or ".." in Path(name).parts:
            bound = "must be in the folder of the project file or below it"
            raise SpecError(argument, bound, name, "move it there")
        path = str(Path(project).parent / name)
        return read_text(path, argument, "must be a file that can be read")

    return read


def write_all(directory: str, files: Mapping[str, str | bytes], *, force: bool) -> None:
    """Write all files or none; existing ones only with ``force``. Nothing is ever deleted.

    All names are looked at before the first byte, all bytes are on disk before the first
    rename, so a file is there whole or not at all.
    """
    folder = Path(directory)
    refuse_what_is_there(directory, files, force=force)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _write(folder, files)
    except OSError as e:
        bound, reason = "must be a folder that can be written", e.strerror or str(e)
        raise SpecError("--out", bound, _end_of(directory), reason.lower()) from None


def refuse_what_is_there(directory: str, names: Iterable[str], *, force: bool) -> None:
    """Raise SpecError where a file of these names could not be written there."""
    folder = Path(directory)
    if "\0" in directory or not directory:
        raise SpecError("--out", "must be the name of a folder", directory, "name one")
    if folder.exists() and not folder.is_dir():
        raise SpecError("--out", "must be a folder", _end_of(str(folder)), "name another one")
    for name in names:
        if Path(name).name != name:
            raise SpecError("file name", "must be a plain name", name, "this is a defect of zoh")
        path = folder / name
        if not os.path.lexists(path):
            continue
        if not force:
            bound = "must not hold a file of that name already"
            raise SpecError(
                "--out", bound, _end_of(str(path)), "add --force, or name another folder"
            )
        if path.is_dir():
            raise SpecError(
                "--out", "must not hold a folder of that name", _end_of(str(path)), "move it"
            )


def _write(folder: Path, files: Mapping[str, str | bytes]) -> None:
    parts = {name: folder / f".{name}.{os.getpid()}.part" for name in files}
    made: list[Path] = []
    try:
        for name, content in files.items():
            with open(parts[name], "xb") as file:
                made.append(parts[name])
                file.write(content.encode() if isinstance(content, str) else content)
        for name, part in parts.items():
            os.replace(part, folder / name)
    finally:
        for part in made:
            part.unlink(missing_ok=True)  # our own scratch, after a failure


def _end_of(path: str) -> str:
    """Return the end of a long path, which says more than its beginning."""
    return path if len(path) <= 55 else "..." + path[-50:]
