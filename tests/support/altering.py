"""Every single change of a results dataset: of each variable, coordinate and attribute, in each way that there is."""

import json

import numpy as np

OTHER_NAN = np.array(0xFFF8000000000001, np.uint64).view(np.float64).item()
NUMBERS = {"f": (0.125, np.nan, OTHER_NAN, np.inf, -np.inf, 1e300, 0.0, -0.0), "i": (7, -1, 0, -2), "u": (7, 0)}
TYPES = {"f": ("f4", ">f8", "i8"), "i": ("i2", "f8", "u8", ">i8"), "u": ("i4", "f8"), "O": ()}


def same(one, other):
    """Whether two arrays are the same to the last bit, type and all."""
    if one.dtype != other.dtype or one.shape != other.shape:
        return False
    return one.tolist() == other.tolist() if one.dtype.kind == "O" else one.tobytes() == other.tobytes()


def places_in(values):
    """Indices of each kind of place: the first and the last, what is missing, infinite or nothing, and what is not."""
    flat = values.ravel()
    if flat.dtype.kind == "O":
        return sorted({0, flat.size - 1})
    missing = flat == -1 if flat.dtype.kind == "i" else np.isnan(flat.astype(np.float64))
    kinds = (missing, ~missing, np.isinf(flat.astype(np.float64)), flat == 0)
    found = [where[k] for kind in kinds if (where := np.flatnonzero(kind)).size for k in (0, -1)]
    return sorted({0, flat.size - 1, *map(int, found)})


def arrays(values):
    """Other arrays in the place of this one: what was done, and the array."""
    for place in places_in(values):
        old = values.ravel()[place]
        texts = ("other", "", f"{old} ", str(old).swapcase())
        for new in texts if values.dtype.kind == "O" else NUMBERS[values.dtype.kind]:
            changed = values.ravel().copy()
            changed[place] = new
            yield f"[{place}] = {new!r}", changed.reshape(values.shape)
    for axis in range(values.ndim):
        yield f"reversed along {axis}", np.flip(values, axis)
    if values.dtype.kind == "f":
        yield "the next numbers", np.nextafter(values, 2.0)
        yield "all NaN", np.full_like(values, np.nan)
        yield "negative", -values
    if values.dtype.kind == "i":
        yield "all -1", np.full_like(values, -1)
    with np.errstate(invalid="ignore"):
        for kind in TYPES[values.dtype.kind]:
            yield f"as {kind}", values.astype(kind)


def of_attribute(value):
    """Other values of an attribute; None takes it away."""
    yield None
    yield from (str(value), f"{value} ", "", np.float64(0.5), np.int64(7), [1, 2])
    if isinstance(value, str) and value[:1] in "[{":
        yield json.dumps(json.loads(value), indent=1)
    elif not isinstance(value, str):
        yield from (value + type(value)(1), float(value), -value)


def attributes(attrs):
    """Other attributes: what was done, and all of them."""
    for key, value in attrs.items():
        for other in of_attribute(value):
            kind = type(value.item() if isinstance(value, np.generic) else value)
            if not isinstance(other, kind) or np.any(other != value):
                changed = {k: v for k, v in (attrs | {key: other}).items() if v is not None}
                yield key, f"{key} = {str(other)[-20:]!r}", changed
    yield "note", "note added", attrs | {"note": "x"}


def alterations(data, names=None):
    """Every way in which variables of a dataset are changed, these or all: what was done, and the dataset with it."""
    for name, variable in data.variables.items():
        if names is not None and name not in names:
            continue
        for how, values in arrays(variable.values):
            if not same(values, variable.values):
                yield f"{name} {how}", data.assign({name: (variable.dims, values, variable.attrs, variable.encoding)})
        yield f"{name} removed", data.drop_vars(name)
        yield f"{name} twice", data.assign({f"{name}_too": variable})
        if variable.ndim > 1:
            yield f"{name} transposed", data.assign({name: variable.transpose(*reversed(variable.dims))})
        if name not in data.dims:
            moved = data.reset_coords(name) if name in data.coords else data.set_coords(name)
            yield f"{name} a coordinate or not", moved
        for _, how, attrs in attributes(variable.attrs):
            changed = data.copy()
            changed[name].attrs = attrs
            yield f"{name}: {how}", changed


def of_the_whole(data):
    """The same of the attributes of the dataset."""
    for key, how, attrs in attributes(data.attrs):
        yield f"attribute {key}: {how}", data.drop_attrs(deep=False).assign_attrs(attrs)
