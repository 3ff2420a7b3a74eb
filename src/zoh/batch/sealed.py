"""A Zarr store whose every file is held against its seal as it is read."""

from collections.abc import Mapping
from pathlib import Path
from zlib import crc32

from zarr.abc.store import ByteRequest
from zarr.core.buffer import Buffer, BufferPrototype
from zarr.storage import LocalStore

from zoh.batch.store import NONE, not_whole


class Sealed(LocalStore):
    """A folder to be read; what is not as it was written raises SpecError.

    Zarr alone takes a chunk that is not there for one that holds nothing but its fill value.
    """

    def __init__(self, root: Path | str, *, seals: Mapping[str, int]) -> None:
        super().__init__(root, read_only=True)
        self.seals = seals

    async def get(
        self,
        key: str,
        prototype: BufferPrototype | None = None,
        byte_range: ByteRequest | None = None,
    ) -> Buffer | None:
        """Return the bytes of a file, None where none was written."""
        found = await super().get(key, prototype)
        self._hold(key, found)
        return found if byte_range is None else await super().get(key, prototype, byte_range)

    def get_sync(
        self,
        key: str,
        *,
        prototype: BufferPrototype | None = None,
        byte_range: ByteRequest | None = None,
    ) -> Buffer | None:
        """Return the same, asked for without a loop of events."""
        found = super().get_sync(key, prototype=prototype)
        self._hold(key, found)
        if byte_range is None:
            return found
        return super().get_sync(key, prototype=prototype, byte_range=byte_range)

    def _hold(self, key: str, found: Buffer | None) -> None:
        sealed = self.seals.get(key)
        has = NONE if found is None else crc32(found.to_bytes())
        if sealed is not None and has != sealed:
            raise not_whole(str(self.root), key)
