"""Where a study's arrays lie while it runs: in memory, or, where they are large, in files that have no name."""

import contextlib
import ctypes
import math
import mmap
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError

LARGE_BYTES = 16_000_000  # of an array from which on it lies in a file
BLOCK = 2_000_000  # numbers that are written at once
FRESH_BYTES = 16_000_000  # that are put into arrays before memory is looked after


class Room:
    """Makes arrays of missing numbers: large ones in files of a folder, if one is given.

    The system then keeps of them in memory what there is room for. The files go with the process, however it ends.
    """

    def __init__(self, folder: Path | None = None) -> None:
        """Know the folder."""
        self.folder = folder
        self._maps: list[mmap.mmap] = []
        self._fresh = 0

    def full(self, shape: tuple[int, ...], missing: float, kind: Any) -> NDArray[Any]:
        """An array in which all numbers are `missing`. Raises InputError where the folder's disk is full."""
        size = math.prod(shape)
        if self.folder is None or size * np.dtype(kind).itemsize < LARGE_BYTES:
            return np.full(shape, missing, kind)
        try:
            with tempfile.TemporaryFile(dir=self.folder) as file:
                for first in range(0, size, BLOCK):  # written, not mapped: where there is no room, one is told
                    file.write(np.full(min(BLOCK, size - first), missing, kind).tobytes())
                file.flush()
                pages = mmap.mmap(file.fileno(), 0)
        except OSError as error:
            raise InputError(f"cannot keep results in {self.folder}: {error.strerror or error}") from error
        self._maps.append(pages)
        return np.frombuffer(pages, kind).reshape(shape)

    def wrote(self, size: int) -> None:
        """So many bytes were put into arrays: now and then memory that is not needed goes back to the system."""
        self._fresh += size
        if self._fresh < FRESH_BYTES:
            return
        self._fresh = 0
        if hasattr(mmap, "MADV_DONTNEED"):  # what was put there is in the file
            for pages in self._maps:
                pages.madvise(mmap.MADV_DONTNEED)
        with contextlib.suppress(OSError, AttributeError, TypeError):  # other C libraries have none of its name
            ctypes.CDLL(None).malloc_trim(0)  # glibc keeps arrays of some megabytes that were freed, thread by thread
