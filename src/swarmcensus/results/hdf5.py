"""HDF5 files despite two faults of its library: it reads some damaged files for ever, and a full disk crashes it."""

import io
import os
import re
from pathlib import Path
from typing import Any

import h5py

HEAP = re.compile(rb"GCOL\x01")  # how a block of texts begins
OVERLAP = 4  # bytes, one less than HEAP has
BLOCK = 1 << 20  # bytes that are searched at a time


class Remembering(h5py.File):  # type: ignore[misc]
    """An HDF5 file that opens each object once; h5netcdf opens each variable some forty times."""

    def __init__(self, file: Any, mode: str, **options: Any) -> None:
        """Open a path, or a file object."""
        super().__init__(file, mode, locking=False, **options)  # files are replaced whole, and never changed
        self.changes = mode != "r"
        self.seen: dict[str, tuple[Any, Any]] = {}

    def __getitem__(self, name: Any) -> Any:
        """The object of this name."""
        if not isinstance(name, str):  # a reference
            return super().__getitem__(name)
        # the link changes when an object is replaced
        link = self.changes and name != "/" and self.id.links.get_info(name.encode()).u
        if name not in self.seen or self.seen[name][0] != link:
            self.seen[name] = link, super().__getitem__(name)
        return self.seen[name][1]


class Output(io.FileIO):
    """A file that HDF5 writes; closing it raises the first OSError of writing.

    HDF5 must not see this error: it cannot close a file that it cannot write, and ends the process with a signal.
    """

    def __init__(self, path: Path) -> None:
        """Open an existing file."""
        super().__init__(path, "r+")
        self.error: OSError | None = None

    def write(self, data: Any, /) -> int:
        """Write all bytes, or remember why they cannot be written."""
        view = memoryview(data).cast("B")
        size = view.nbytes
        try:
            while self.error is None and view:
                view = view[super().write(view) :]
        except OSError as error:
            self.error = error
        return size

    def readinto(self, buffer: Any, /) -> int:
        """Read bytes; those that were not written are zeros, as HDF5 does not ask how many were read."""
        view = memoryview(buffer).cast("B")
        size = super().readinto(view) or 0
        view[size:] = bytes(view.nbytes - size)
        return view.nbytes

    def truncate(self, size: int | None = None, /) -> int:
        """Set the size, unless writing failed before."""
        try:
            return super().truncate(size) if self.error is None else 0
        except OSError as error:
            self.error = error
            return 0

    def close(self) -> None:
        """Close the file. Raises OSError if it could not be written."""
        super().close()
        if self.error:
            raise self.error


def broken_texts(path: Path) -> int | None:
    """The byte at which a damaged block of texts (a "global heap") begins that HDF5 would read for ever, or None."""
    with path.open("rb") as file:
        start, raw = 0, b""
        while block := file.read(BLOCK):
            raw += block
            for found in HEAP.finditer(raw):
                if not _ends(file, start + found.start()):
                    return start + found.start()
            raw, start = raw[-OVERLAP:], start + max(0, len(raw) - OVERLAP)
            file.seek(start + len(raw))
    return None


def read_indices(file: h5py.File) -> None:
    """Read the indices by order of creation, which reading by names leaves out. Raises RuntimeError for damage."""
    by_creation, as_it_is = h5py.h5.INDEX_CRT_ORDER, h5py.h5.ITER_NATIVE
    file.id.links.iterate(lambda _: None, idx_type=by_creation, order=as_it_is)
    for one in (file, *file.values()):
        h5py.h5a.iterate(one.id, lambda _: None, index_type=by_creation, order=as_it_is)


def _ends(file: io.BufferedReader, at: int) -> bool:
    """Whether the objects of a block of texts end: each has a header of 16 bytes, with its number and its size."""
    file.seek(at + 8)
    end = at + int.from_bytes(file.read(8), "little")
    if end > os.fstat(file.fileno()).st_size:  # no such block, or one that HDF5 refuses
        return True
    at += 16
    while at + 16 <= end:
        file.seek(at)
        header = file.read(16)
        if len(header) < 16:  # HDF5 sees that the file was cut
            return True
        size = int.from_bytes(header[8:], "little")
        if header[:2] != b"\0\0":  # otherwise it is what is left, and the size includes the header
            size = 16 + -(-size // 8) * 8
        at += size
        if not size or at > end:
            return False
    return True
