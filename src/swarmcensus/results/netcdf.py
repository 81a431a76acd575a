"""Datasets as netCDF-4 files, with hashes of their content, by which damage is found.

The library of HDF5 reads some damaged files for ever, and a full disk crashes it: a copy of this process reads first
what is small, and an `Output` keeps errors of writing from the library. A process with several threads cannot have a
copy: damaged texts, of which HDF5 finds no end, are looked for in the bytes.
"""

import contextlib
import hashlib
import io
import json
import mmap
import re
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

import h5netcdf
import h5py
import numpy as np
import xarray as xr

from swarmcensus.results import schema
from swarmcensus.results.values import ALL_VARIABLES, MISSING
from swarmcensus.support.errors import ResultsError
from swarmcensus.support.files import atomic_write
from swarmcensus.support.fork import in_background
from swarmcensus.support.options import command

HASHES, HASH_OF_ATTRIBUTES = "sha256", "sha256_of_attributes"  # the attributes of a file that hold them
SMALL = {"compression": "gzip", "compression_opts": 1, "shuffle": True}  # how whole numbers are packed
MOST_PACKED = 1100  # bytes that a byte of a file may stand for: deflate reaches 1032
LARGE_BYTES = 4_000_000  # arrays of more are read once all else is known to be right
SECONDS, BYTES_A_SECOND, MEMORY = 3.0, 5_000_000, 2_000_000_000  # what reading all else may take
HEAP = re.compile(rb"GCOL\x01")  # how a block of texts begins
ADDED = ("_FillValue", "coordinates")  # attributes of variables by which others read a file as it is meant
CHANGED = "it was damaged or edited since it was saved"


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


def write(data: xr.Dataset, path: str | Path, *, hashed: bool) -> None:
    """Write a dataset, whole or not at all; `hashed` adds the hashes that `read` asks for. Raises InputError."""
    variables, attributes = _as_kept(data), dict(data.attrs)
    if hashed:
        attributes[HASHES] = json.dumps({name: _hash(one) for name, one in variables.items()})
        attributes[HASH_OF_ATTRIBUTES] = _hash_of_attributes(attributes)
    with (
        atomic_write(path) as temporary,
        Output(temporary) as output,
        Remembering(output, "w", track_order=True) as file,
        h5netcdf.File(file, "w") as netcdf,
    ):
        netcdf.dimensions = {str(name): size for name, size in data.sizes.items()}
        for name, one in variables.items():
            kind = h5py.string_dtype() if one.dtype.kind == "O" else one.dtype
            packing: dict[str, Any] = SMALL if one.dtype.kind in "iu" and one.size > 1000 else {}
            made = netcdf.create_variable(name, one.dims, kind, fillvalue=one.attrs.get("_FillValue"), **packing)
            made.attrs.update({key: value for key, value in one.attrs.items() if key != "_FillValue"})
            made[...] = one.values
        netcdf.attrs.update(attributes)


def read(path: Path) -> xr.Dataset:
    """Read a results file as it was saved, with whole numbers for times.

    Raises ResultsError if it is not one, or was damaged or edited since. Nothing large is read before types, sizes and
    dimensions are known to be right.
    """
    bounds = SECONDS + path.stat().st_size / BYTES_A_SECOND, MEMORY
    attributes, hashes, variables, large = in_background(partial(_read, path), bounds=bounds, if_killed=_fail)()
    if large:
        with _naming_damage(), h5py.File(path, "r", locking=False) as file:
            for name in large:
                dims, attrs = variables[name]
                variables[name] = _variable(file[name], dims, attrs, hashes[name])
    return _dataset(variables, attributes)


def _read(path: Path) -> tuple[dict[str, Any], dict[str, str], dict[str, Any], list[str]]:
    """A file's attributes, hashes, variables, and the names of the large ones. Raises ResultsError.

    Those have dimensions and attributes only.
    """
    variables: dict[str, Any] = {}
    with _naming_damage(), path.open("rb") as raw, mmap.mmap(raw.fileno(), 0, access=mmap.ACCESS_READ) as content:
        for block in HEAP.finditer(content):
            _check_texts(content, block.start())
    with _naming_damage(), Remembering(path, "r") as file:
        for name in file:
            _check_place(file, name)
        with h5netcdf.File(file, "r", decode_vlen_strings=True) as netcdf:
            attributes = {key: _plain(value) for key, value in netcdf.attrs.items()}
            kinds = {str(name): (one.dimensions, file[name].dtype) for name, one in netcdf.variables.items()}
            hashes = _checked(attributes, kinds)
            large = [name for name, (_, kind) in kinds.items() if kind.kind != "O" and file[name].nbytes > LARGE_BYTES]
            for name, (dims, _) in kinds.items():
                about = dims, {key: _plain(value) for key, value in netcdf.variables[name].attrs.items()}
                variables[name] = about if name in large else _variable(file[name], *about, hashes[name])
    return attributes, hashes, variables, large


@contextlib.contextmanager
def _naming_damage() -> Iterator[None]:
    """Raise ResultsError for whatever HDF5 raises about a damaged file."""
    try:
        yield
    except ResultsError:
        raise
    except Exception as error:
        why = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise ResultsError(f"not a readable netCDF-4 file (cut short or damaged?): {why}") from error


def _fail() -> NoReturn:
    raise ResultsError("not a readable netCDF-4 file (cut short or damaged?): the library of HDF5 cannot read it")


def _variable(stored: h5py.Dataset, dims: tuple[str, ...], attrs: dict[str, Any], hashed: str) -> xr.Variable:
    """A variable of a file. Raises ResultsError if its hash is another one."""
    if stored.dtype.kind == "O":
        values = np.asarray(stored.asstr()[()], object)
    else:
        values = np.asarray(stored[()], stored.dtype.newbyteorder("="))
    variable = xr.Variable(dims, values, attrs)
    if _hash(variable) != hashed:
        raise ResultsError(f"{CHANGED}: {stored.name.removeprefix('/')} differs")
    return variable


def _check_texts(content: mmap.mmap, block: int) -> None:
    """Raise ResultsError unless the objects of a block of texts (a "global heap") end with the block.

    Each has a header of 16 bytes, with its number and its size.
    """
    end, at = block + int.from_bytes(content[block + 8 : block + 16], "little"), block + 16
    while at + 16 <= end <= len(content):  # HDF5 itself refuses a block that is cut
        size = int.from_bytes(content[at + 8 : at + 16], "little")
        if content[at : at + 2] != b"\0\0":  # otherwise it is what is left, and the size includes the header
            size = 16 + -(-size // 8) * 8
        at += size
        if not size or at > end:
            raise ResultsError(f"{CHANGED}: its texts at byte {block:,} are damaged")


def _check_place(file: h5py.File, name: str) -> None:
    """Raise ResultsError unless something is a plain array in its file: HDF5 could read it from any other."""
    if not isinstance(file.get(name, getlink=True), h5py.HardLink):
        raise ResultsError(f"{name} is a link")
    one = file[name]
    if not isinstance(one, h5py.Dataset):
        raise ResultsError(f"{name} is a group")
    bare = "CLASS" in one.attrs and one.attrs["CLASS"] == b"DIMENSION_SCALE" and not one.id.get_storage_size()
    if one.is_virtual or one.external or (one.nbytes > MOST_PACKED * one.id.get_storage_size() and not bare):
        raise ResultsError(f"the numbers of {name} are not in the file")


def _checked(attributes: dict[str, Any], variables: Mapping[str, schema.Declared]) -> dict[str, str]:
    """The hashes of a file that has what the schema declares, taken from its attributes. Raises ResultsError."""
    if not str(attributes.get("format")).startswith("swarmcensus results"):
        traced = "brain" in attributes and {"round", "robot"} <= {*variables.get("estimate", ((), None))[0]}
        what = "a trace, not results: swarmcensus plot --kind curves draws what it was made from" if traced else ""
        raise ResultsError(what or "not a results file of swarmcensus")
    if attributes["format"] != schema.FORMAT:
        why = f"its format is {attributes['format']!r}, and this version of swarmcensus reads {schema.FORMAT!r}"
        raise ResultsError(why, key="format", value=attributes["format"])
    if not {HASHES, HASH_OF_ATTRIBUTES} <= {*attributes}:
        again = command("swarmcensus", "run", "STUDY.toml", "--fresh")
        raise ResultsError(f"it has no hashes, by which damage is found: make it again from its study, as with {again}")
    if attributes.pop(HASH_OF_ATTRIBUTES) != _hash_of_attributes(attributes):
        raise ResultsError(f"{CHANGED}: its attributes differ")
    hashes: dict[str, str] = json.loads(attributes.pop(HASHES))
    for name in sorted(hashes.keys() ^ variables.keys()):
        differs = "is missing" if name in hashes else "was added"
        raise ResultsError(f"{CHANGED}: {name} {differs}")
    schema.check(attributes, variables)
    return hashes


def _as_kept(data: xr.Dataset) -> dict[str, xr.Variable]:
    """The variables of a dataset with the attributes that netCDF adds: coordinates, and what means missing."""
    coordinates = {str(name): {*one.dims} for name, one in data.coords.items() if name not in data.dims}
    variables = {}
    for name, one in data.variables.items():
        values = one.values.astype(object) if one.dtype.kind in "UT" else one.values
        values = values.astype(np.int8) if values.dtype.kind == "b" else values
        attrs = dict(one.attrs)
        if values.dtype.kind == "f":
            attrs["_FillValue"] = values.dtype.type(np.nan)
        elif name in ALL_VARIABLES:
            attrs["_FillValue"] = values.dtype.type(MISSING)
        of = sorted(each for each, dims in coordinates.items() if dims <= {*one.dims})
        if of and name not in data.coords:
            attrs["coordinates"] = " ".join(of)
        variables[str(name)] = xr.Variable(one.dims, values, attrs)
    return variables


def _dataset(variables: Mapping[str, xr.Variable], attributes: Mapping[str, Any]) -> xr.Dataset:
    """The dataset of which `_as_kept` made variables. Raises ResultsError if it would make others."""
    added = {name: {key: one.attrs.pop(key, None) for key in ADDED} for name, one in variables.items()}
    named = " ".join(str(found["coordinates"]) for found in added.values()).split()
    coordinates = {*named, *(dim for one in variables.values() for dim in one.dims)}
    data = xr.Dataset(variables, attrs=attributes).set_coords(coordinates & variables.keys())
    for name, one in _as_kept(data).items():
        for key, value in added[name].items():
            if repr(value) != (right := repr(_plain(one.attrs.get(key)))):  # NaN is not equal to itself
                raise ResultsError(f"{CHANGED}: {key} of {name} is {value!r}, and should be {right}", key=name)
    return data


def _hash(one: xr.Variable) -> str:
    """The hash of a variable, which does not depend on how a file keeps it."""
    is_text, order = one.dtype.kind == "O", one.dtype.newbyteorder("<")
    head = [one.dims, "text" if is_text else order.str, one.shape, {key: _plain(one.attrs[key]) for key in one.attrs}]
    found = hashlib.sha256(json.dumps(head, sort_keys=True, default=str).encode())
    found.update(json.dumps(one.values.tolist()).encode() if is_text else np.ascontiguousarray(one.values, order).data)
    return found.hexdigest()


def _hash_of_attributes(attributes: Mapping[str, Any]) -> str:
    plain = {key: _plain(value) for key, value in attributes.items()}
    return hashlib.sha256(json.dumps(plain, sort_keys=True, default=str).encode()).hexdigest()


def _plain(value: Any) -> Any:
    """An attribute as Python has it; netCDF does not tell a number from a list of one."""
    if not isinstance(value, np.generic | np.ndarray | list | tuple):
        return value
    values = np.ravel(value).tolist()
    return values[0] if len(values) == 1 else values
