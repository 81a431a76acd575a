"""The page specifies the bytes of messages: its examples hold, and a codec written from it alone gives the same."""

import hashlib
import math
import random
import re
import struct
import zlib

import pytest

from swarmcensus import brains
from swarmcensus.brains.packing import Numbers
from swarmcensus.robots.target import mark_of
from swarmcensus.runtime.runtime import Messages
from tests.support.places import ROOT

LARGEST = 3.4028234663852886e38


def packer(coding, feedback=False):
    """The runtime's messages of one part."""
    count = 2 if coding in ("ratio16", "ratio8") else 1
    return Messages([0] * count, [(coding, tuple(range(count)), feedback)], 0, False)


def test_examples_of_the_page():
    text = (ROOT / "docs" / "data-format.md").read_text(encoding="utf-8")
    found = re.findall(r"\| (\w+) \| ([-\d., e]+) \| `([\da-f ]+)` \|", text.partition("**Feedback.**")[2])
    assert {coding for coding, *_ in found} == set(CODINGS)
    for coding, numbers, code in found:
        said = tuple(float(x) for x in numbers.split(","))
        assert packer(coding).coded(said) == bytes.fromhex(code)
        assert written(coding, said) == bytes.fromhex(code)
    [sequence] = re.findall(r"\| share8 with feedback \| 0.55, then six times again \| `([\da-f ]+)` \|", text)
    one = packer("share8", True)
    assert b"".join(one.coded((0.55,)) for _ in range(7)) == bytes.fromhex(sequence)


# ---- a codec that was written from the page alone
def ieee(form, x, limit, largest):
    if x != x:
        return bytes(2) if form == "<e" else struct.pack(form, x)
    if abs(x) >= limit:
        x = math.copysign(largest, x)
    return struct.pack(form, x if x else 0.0 if form == "<e" else x)


def share(bits, x):
    s = {16: 32768, 8: 128}[bits]
    code = round(min((x + 0.5) * s, 2 * s - 1)) if x > -0.5 else 0
    return code.to_bytes(bits // 8, "little")


def log8(x):
    if not x >= 1.3992e-05:
        return b"\0"
    if x >= 2**47.5:
        return b"\xff"
    m, e = math.frexp(x)
    return bytes([4 * (e + 15) + 1 + sum(m >= 2 ** (-k / 8) for k in (7, 5, 3, 1))])


def pair(bits, information, confidence):
    return share(bits, information / confidence if confidence > 0 else 0.5) + log8(confidence)


CODINGS = {
    "float32": lambda x: ieee("<f", x, LARGEST, LARGEST), "float16": lambda x: ieee("<e", x, 65520, 65504),
    "share16": lambda x: share(16, x), "share8": lambda x: share(8, x), "log8": log8,
    "whole16": lambda x: (round(min(x, 65535)) if x > 0 else 0).to_bytes(2, "little"),
    "ratio16": lambda i, c: pair(16, i, c), "ratio8": lambda i, c: pair(8, i, c),
}  # fmt: skip


def written(coding, said):
    return CODINGS[coding](*said)


def numbers(coding, chance):
    """Numbers of every size, the middles between two codes, and the ends."""
    size = math.copysign(2 ** chance.uniform(-30, 50), chance.random() - 0.3)
    if coding in ("ratio16", "ratio8"):
        confidence = chance.choice([abs(size), 0.0, -1.0, 2.0 ** chance.randint(-20, 60)])
        return chance.uniform(-0.7, 1.7) * confidence, confidence
    middle = (chance.randrange(300) + 0.5) / 128 - 0.5
    return (chance.choice([size, middle, chance.uniform(-0.6, 1.6), chance.randrange(70_000) / 2, 1e39, -1e39, -0.0]),)


@pytest.mark.parametrize("coding", CODINGS)
def test_a_codec_written_from_the_page_has_the_same_bytes(coding):
    """How they are read, and what is owed to the next one: unit/runtime/test_runtime.py, against the reference."""
    chance, one = random.Random(coding), packer(coding)
    for _ in range(3000):
        said = numbers(coding, chance)
        assert written(coding, said) == one.coded(said), said
    not_a_number = (math.nan,) * len(said)
    assert written(coding, not_a_number) == one.coded(not_a_number)


@pytest.mark.parametrize("format_", ["float32", "float16", "ratio16", "ratio8"])
@pytest.mark.parametrize("name", ["commons", "minimalistic", "voter", "census", "self-taught", "belief-sharing"])
def test_datagrams_written_from_the_page(name, format_):
    """Parts by role, the mark and the checksum."""
    brain = brains.load(name).with_numbers(Numbers(message=format_))
    text = f"{hashlib.sha256(brain.source.encode()).hexdigest()} {format_}"
    mark = int(hashlib.sha256(text.encode()).hexdigest()[:8], 16)
    assert mark == mark_of(brain)
    chance = random.Random(name)
    said = {field: [chance.random() for _ in range(length or 1)] for field, length in brain.message.items()}
    message = tuple(tuple(said[f]) if length else said[f][0] for f, length in brain.message.items())
    one = Messages(tuple(brain.message.values()), brain.parts, mark, True)
    head = bytes([mark & 255, 300 & 255]) + (7).to_bytes(2, "little") + (70_000 & 0xFFFF).to_bytes(2, "little")
    body = head + b"".join(written(*part) for part in parts_of(brain, said, format_))
    assert one.pack(message, 300, 7, 70_000) == body + zlib.crc32(body, mark).to_bytes(4, "little")


def parts_of(brain, said, format_):
    """Codings and numbers of a message, by the page's table of roles."""
    if format_ in ("float32", "float16"):
        return [(format_, [x]) for numbers in said.values() for x in numbers]
    roles, names, bits = brain.roles, list(said), format_.removeprefix("ratio")
    confidences = [name for name in names if roles.get(name) == "confidence"]
    taken = {}
    for name in names:
        if roles.get(name) == "information":
            after = [c for c in confidences if names.index(c) > names.index(name)]
            confidence = (after or confidences)[0]
            if confidence not in taken.values():
                taken[name] = confidence
    alone = {
        "estimate": f"share{bits}", "confidence": "log8", "opinion": "share8", "option": "whole16", "name": "whole16",
        "belief": "float16",
    }  # fmt: skip
    parts = []
    for name in names:
        if name in taken:
            parts += [(format_, both) for both in zip(said[name], said[taken[name]], strict=True)]
        elif name not in taken.values():
            parts += [(alone.get(roles.get(name), "float32"), [x]) for x in said[name]]
    return parts
