"""Fields of a record are its attributes in CPython, whatever NumPy calls so."""

import numpy as np
import pytest

from swarmcensus.engine.records import record_type

NUMPYS = sorted(name for name in {*dir(np.recarray), *dir(np.record)} if not name.startswith("_"))


def test_fields_hide_numpy_attributes():
    record = np.zeros(1, record_type([(name, "f8") for name in NUMPYS] + [("vector", "f8", (3,))]))[0]
    for k, name in enumerate(NUMPYS):
        setattr(record, name, k)
    record.vector[1] = 7.0
    assert [getattr(record, name) for name in NUMPYS] == [*range(len(NUMPYS))]
    assert record.vector.tolist() == [0.0, 7.0, 0.0]
    with pytest.raises(AttributeError):
        record.other = 1.0


def test_a_number_is_one_of_cpython():
    record = np.zeros(1, record_type([("mean", "f8")]))[0]
    with pytest.raises(ZeroDivisionError):
        1.0 / record.mean
