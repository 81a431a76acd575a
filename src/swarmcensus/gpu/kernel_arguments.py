"""What a kernel is given: numbers and addresses, each of eight bytes, in the order in which they are declared here."""

import ctypes
from collections.abc import Mapping

# keys of random words
KEYS = {"readings_key": 2, "losses_key": 2, "order_key": 2, "luck_key": 4}
WHOLE = """
first trials robots rounds looks delay together sensors kinds beliefs drifts stop_rows graphs liars checkpoints keeps
chunk chunk_at piece tables_made k
""".split()  # noqa: SIM905 - read more easily than a list
REAL = {"course": 4, "delta": 1}
ARRAYS = {  # by name: the type of an item
    "b": "double", "w": "double", "drift": "double", "assumed_b": "double", "assumed_w": "double", "blanks": "number",
    "stops": "int64_t", "bounds": "int64_t", "senders": "uint32_t", "groups": "uint8_t", "honest": "uint8_t",
    "counted": "int64_t", "rounds_of": "int64_t", "bins": "double", "stand": "double", "tables": "uint64_t",
    "memory": "uint64_t", "outbox": "number", "signals": "uint8_t", "parts": "number", "around": "number",
    "rows": "double", "extremes": "uint64_t", "tallies": "uint32_t", "sought": "uint64_t", "widths": "double",
    "said": "uint32_t", "decisions": "int16_t", "amiss": "uint8_t", "clipped": "int64_t",
    "sent": "int64_t", "heard": "int64_t", "verdicts": "double", "bounds_of": "double", "where": "int64_t",
    "value": "double", "final": "double", "agreed": "int64_t", "correct": "double", "disagreement": "double",
    "kept": "double", "unanimous": "int16_t",
}  # fmt: skip


class Given(ctypes.Structure):
    """The argument of every kernel; arrays by address."""

    _fields_ = (
        [(name, ctypes.c_uint64 * count) for name, count in KEYS.items()]
        + [("threshold", ctypes.c_uint64)]
        + [(name, ctypes.c_int64) for name in WHOLE]
        + [(name, ctypes.c_double * count if count > 1 else ctypes.c_double) for name, count in REAL.items()]
        + [(name, ctypes.c_uint64) for name in ARRAYS]
    )


def _declarations(kinds: Mapping[str, int], kind: str) -> list[str]:
    return [f"    {kind} {name}{f'[{count}]' if count > 1 else ''};" for name, count in kinds.items()]


STRUCT = "\n".join(
    ["struct Given {", *_declarations(KEYS, "uint64_t"), "    uint64_t threshold;"]
    + _declarations(dict.fromkeys(WHOLE, 1), "int64_t")
    + _declarations(REAL, "double")
    + [f"    {kind} *{name};" for name, kind in ARRAYS.items()]
    + ["};"]
)
