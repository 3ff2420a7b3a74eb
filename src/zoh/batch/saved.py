"""A sweep that was held in memory as a new file: netCDF, or a Zarr store."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

from zoh.batch import store
from zoh.batch.extras import needed
from zoh.errors import SpecError

if TYPE_CHECKING:
    from xarray import Dataset


def write_netcdf(found: "Dataset", path: str) -> None:
    """Write a dataset to a new netCDF 4 file, whole or not at all."""
    refuse_netcdf(path)
    part = Path(f"{path}.{os.getpid()}.part")
    try:
        found.to_netcdf(part, engine="h5netcdf")
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def refuse_netcdf(path: str) -> None:
    """Raise SpecError where no new netCDF file can be written: to be asked before the work."""
    needed("h5netcdf", "a netCDF file")
    store.absolute(path)
    _refuse_what_is_there(path)
    folder = Path(path).absolute().parent
    if not folder.is_dir():
        raise SpecError("path", "must be in a folder that is there", path, f"make {folder}")


def refuse_zarr(path: str) -> None:
    """Raise SpecError where no new Zarr store can be written: to be asked before the work."""
    needed("zarr", "a Zarr store")
    store.absolute(path)
    _refuse_what_is_there(path)


def write_zarr(found: "Dataset", path: str) -> None:
    """Write a dataset to a new Zarr store, sealed as ``zoh.open_sweep`` asks for."""
    refuse_zarr(path)
    try:
        _write_zarr(found, path)
    except OSError as refused:
        raise store.not_writable(path, refused) from refused


def _write_zarr(found: "Dataset", path: str) -> None:
    folder = Path(path)
    found.to_zarr(path, mode="w-", consolidated=False)
    files = {f.relative_to(folder).as_posix(): f for f in folder.rglob("*") if f.is_file()}
    root = files.pop(store.ROOT)
    seals = {place: store.seal(file) for place, file in sorted(files.items())}
    store.put(root, store.root(root.read_bytes(), {}, seals))


def _refuse_what_is_there(path: str) -> None:
    if os.path.lexists(path):
        raise SpecError("path", "must not be there already", path, "name another one")
