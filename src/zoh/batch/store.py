"""The files of a sweep on disk, and whether each of them is whole.

    zarr.json         what the store is of, the seals of the arrays' own zarr.json, and its own
    NAME/c/K          block K of a column
    blocks/c/K/0      its row: the block's summary, the seals of its columns, and the row's own

A seal is the CRC-32 of a file's bytes, -1 where there is none: Zarr writes no chunk that holds
nothing but its fill value, and reads one that was lost as if it had been so. A row's own seal is
begun with the root's and the block's number, so that no block passes for another, nor for one of
another sweep. Rows are kept as plain little-endian floats, which need no decoder that damage could
bring down.
"""

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
import numpy.typing as npt

from zoh.batch.extras import needed
from zoh.batch.marks import MARK, difference
from zoh.batch.summary import WIDTH
from zoh.errors import SpecError

Row = npt.NDArray[np.float64]

BLOCKS = "blocks"
ROOT = "zarr.json"
NONE = -1  # the seal of a file that is not there
_FLOAT = "<f8"
_NEW = "must be new, or hold the same sweep"
_SCRAP = ".partial"  # what a write that did not come to its end leaves; nothing reads it
_SHOWN = 3  # files of which a refusal gives the names


def absolute(path: object) -> str:
    """Return the whole path of a folder; raise SpecError for what is no path."""
    if not isinstance(path, str | os.PathLike):
        raise SpecError("path", "must be a path", path, "put it in quotes")
    return str(Path(os.fsdecode(path)).absolute())


def seal(file: Path) -> int:
    """Return the seal of a file."""
    try:
        return crc32(file.read_bytes())
    except (FileNotFoundError, NotADirectoryError):
        return NONE


def put(file: Path, contents: bytes) -> None:
    """Put a file in its place whole."""
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_name(f"{file.name}.{os.getpid()}{_SCRAP}")
    part.write_bytes(contents)
    part.replace(file)


def root(contents: bytes, mark: Mapping[str, Any], files: Mapping[str, int]) -> bytes:
    """Return a root's zarr.json with its mark, the seals of other files, and its own."""
    document = json.loads(contents)
    document["attributes"][MARK] = {**mark, "files": dict(files)}
    document["attributes"][MARK]["seal"] = _seal(document)
    return json.dumps(document, indent=2).encode()


def laid_out(
    about: Mapping[str, Any], mark: Mapping[str, Any], columns: Mapping[str, Mapping[str, Any]]
) -> dict[str, bytes]:
    """Return the files that a store has before any block, by their places, the root's first.

    about    the root's attributes;  mark  what it is known by, its loops and block among it
    columns  of each what Zarr is to know: dtype, fill_value, attributes, dimension_names
    """
    zarr = needed("zarr", "a sweep on disk")
    made: dict[str, Any] = {}
    loops, block = mark["loops"], mark["block"]
    group = zarr.create_group(zarr.storage.MemoryStore(made), attributes=about)
    for name, column in columns.items():
        group.create_array(name=name, shape=(loops,), chunks=(block,), **column)
    width = WIDTH + len(columns) + 1
    group.create_array(
        name=BLOCKS, shape=(-(-loops // block), width), chunks=(1, width), dtype=_FLOAT,
        fill_value=np.nan, compressors=None, dimension_names=("block", "entry"),
    )  # fmt: skip
    files = {place: contents.to_bytes() for place, contents in made.items() if place != ROOT}
    seals = {place: crc32(contents) for place, contents in files.items()}
    return {ROOT: root(made[ROOT].to_bytes(), mark, seals), **files}


def begin(path: str, files: Mapping[str, bytes]) -> None:
    """Write the files of a new store, or mend those of one that the same sweep has begun.

    Raises SpecError, and writes nothing, where the path holds anything else; and where no folder
    can be made there, or nothing written to it.
    """
    try:
        _begin(path, files)
    except OSError as refused:
        raise not_writable(path, refused) from refused


def not_writable(path: str, why: OSError) -> SpecError:
    """Return the refusal of a folder that the system does not let be made or written."""
    bound = f"must be a folder that can be made and written ({why.strerror or why})"
    return SpecError("path", bound, path, "name another folder")


def _begin(path: str, files: Mapping[str, bytes]) -> None:
    folder = Path(path)
    if not _is_fresh(folder):
        if differs := difference(attributes(path, _NEW), _attributes(files[ROOT])):
            way_out = "name another folder, or ask for what it holds"
            raise SpecError("path", f"{_NEW}, but {differs}", path, way_out)
    for place, contents in files.items():
        if seal(folder / place) != crc32(contents):
            put(folder / place, contents)
    for part in folder.glob(f"**/*{_SCRAP}"):
        part.unlink(missing_ok=True)


def attributes(path: str, bound: str) -> dict[str, Any]:
    """Return the attributes of a store; raise SpecError where the path holds none."""
    try:
        return _attributes((Path(path) / ROOT).read_bytes())
    except (FileNotFoundError, NotADirectoryError):
        why = f"it has no {ROOT}" if os.path.lexists(path) else "it is not there"
    except (AttributeError, KeyError, TypeError):
        why = "it holds no sweep"
    except ValueError:
        why = f"its {ROOT} is damaged"
    raise SpecError("path", f"{bound}, but {why}", path, "name another folder")


def _attributes(contents: bytes) -> dict[str, Any]:
    document = json.loads(contents)
    if document["attributes"][MARK].pop("seal") != _seal(document):
        raise ValueError
    return dict(document["attributes"])


def _seal(document: object) -> int:
    return crc32(json.dumps(document, sort_keys=True).encode())


def clear(path: str, number: int, keep: Sequence[str]) -> None:
    """Remove what there is of a block: Zarr would read a damaged chunk that it writes to."""
    for place in (_row_place(number), *(_chunk(name, number) for name in keep)):
        (Path(path) / place).unlink(missing_ok=True)


def sealed(path: str) -> int:
    """Return the root's seal of a store: which sweep it is of."""
    return int(json.loads((Path(path) / ROOT).read_bytes())["attributes"][MARK]["seal"])


def close(path: str, number: int, keep: Sequence[str], summary: Row) -> None:
    """Write the row of a block whose columns are there."""
    seals = [seal(Path(path) / _chunk(name, number)) for name in keep]
    contents = np.array([*summary, *seals], _FLOAT).tobytes()
    own = np.array([_own(contents, number, sealed(path))], _FLOAT).tobytes()
    put(Path(path) / _row_place(number), contents + own)


def summary_of(path: str, number: int, keep: Sequence[str], of: int) -> Row | None:
    """Return the summary of a block of which every byte is as it was written, None of any other.

    of  the root's seal, ``sealed``
    """
    row = _row(path, number, keep, of)
    if row is None:
        return None
    seals = _seals(row, number, keep)
    there = all(seal(Path(path) / place) == sealed for place, sealed in seals.items())
    return row[:WIDTH] if there else None


def seals_of(path: str) -> dict[str, int]:
    """Return the seal of every file of a store, by its place.

    Raises SpecError where one is not there. Whether one is damaged is known once it is read.
    """
    mark = attributes(path, "must be a sweep's store")[MARK]
    found: dict[str, int] = dict(mark["files"])
    missing: list[str] = []
    of = sealed(path)
    for number in range(-(-mark["loops"] // mark["block"]) if "block" in mark else 0):
        row = _row(path, number, mark["keep"], of)
        if row is None:
            missing.append(_row_place(number))
        else:
            found |= _seals(row, number, mark["keep"])
    missing += [k for k, x in found.items() if x != NONE and not (Path(path) / k).is_file()]
    if missing:
        more = f" and {len(missing) - _SHOWN} more" if len(missing) > _SHOWN else ""
        raise not_whole(path, ", ".join(missing[:_SHOWN]) + more)
    return found


def not_whole(path: str, files: str) -> SpecError:
    """Return the refusal of a store of which some files are not as they were written."""
    bound = f"must be a whole store, not one with {files} missing or damaged"
    way_out = "sweep_to of the same sweep makes it whole; what to_zarr wrote must be written anew"
    return SpecError("path", bound, path, way_out)


def _row(path: str, number: int, keep: Sequence[str], of: int) -> Row | None:
    """Return a block's row, None where it is not there or not as it was written."""
    try:
        contents = (Path(path) / _row_place(number)).read_bytes()
    except OSError:
        return None
    if len(contents) != 8 * (WIDTH + len(keep) + 1):
        return None
    row = np.frombuffer(contents, _FLOAT).astype(np.float64)
    return row if row[-1] == _own(contents[:-8], number, of) else None


def _own(contents: bytes, number: int, of: int) -> int:
    """Return a row's own seal."""
    return crc32(contents, of ^ number)


def _seals(row: Row, number: int, keep: Sequence[str]) -> dict[str, int]:
    """Return the seals of a block's columns, by the places of their chunks."""
    places = [_chunk(name, number) for name in keep]
    return {place: int(x) for place, x in zip(places, row[WIDTH:-1], strict=True)}


def _chunk(name: str, number: int) -> str:
    return f"{name}/c/{number}"


def _row_place(number: int) -> str:
    return f"{BLOCKS}/c/{number}/0"


def _is_fresh(folder: Path) -> bool:
    """Return whether nothing is there, or only a first write that did not come to its end."""
    if not folder.is_dir():
        return not os.path.lexists(folder)
    return all(part.match(f"{ROOT}.*{_SCRAP}") for part in folder.iterdir())
