"""Talking to the server of the live page, and reading what it answers."""

import itertools
import json
import subprocess

import numpy as np
from websockets.sync.client import connect

LIARS = "members=[{robots = 0.25, brain = 'always-black', honest = false}]"
PAGE_STUDY = """
trials = 3
seed = 4
swarm.robots = 12
swarm.accuracy = 0.75
world = {topology = ["moving", "ring"], density = 4.0, fill_ratio = 0.6}
schedule = {rounds = 300, ticks = 300}
"""


def programs(folder, what="args"):
    """The processes that run robots of this folder."""
    found = subprocess.run(["ps", "-ww", "-eo", what], capture_output=True, text=True, check=True).stdout
    return [line for line in found.splitlines() if "import node" in line and str(folder) in line]


def talk(served, token=None, **more):
    origin = more.pop("origin", f"http://127.0.0.1:{served.port}")
    address = f"ws://127.0.0.1:{served.port}/live?token={served.token if token is None else token}"
    return connect(address, origin=origin, max_size=None, proxy=None, compression=None, **more)


def heard(page):
    """The next part of an answer; that something is compiled is none."""
    while '"compiling"' in str(said := page.recv(timeout=60)):
        pass
    return said


def ask(page, **words):
    while True:
        page.send(json.dumps(words))
        parts = [heard(page)]
        while isinstance(parts[-1], bytes):
            parts.append(heard(page))
        end = json.loads(parts[-1])
        if not end.get("going"):
            return parts[:-1], end


def parsed(message):
    """A message of frames, read as the page does: numbers by column, and layers, flags and links by frame."""
    _, side, count, robots, columns, layers, _, _ = np.frombuffer(message, "<u4", 8).tolist()
    planes = 1 + 2 * bool(layers & 4) + 2 * bool(layers & 1)
    at = 32
    parts = []
    for kind, size in (("<f8", count * columns), ("<u4", count), ("<u4", count + 1), ("<u2", count * planes * robots), ("u1", count * 2 * robots)):  # fmt: skip  # noqa: E501
        parts.append(np.frombuffer(message, kind, size, at))
        at += parts[-1].nbytes
    numbers, ticks, starts, values, flags = parts
    links = np.frombuffer(message, "<u2" if layers & 4 else "u1", starts[-1], at)
    assert at + links.nbytes == len(message)
    return {
        "side": side, "ticks": ticks, "numbers": numbers.reshape(count, columns),
        "layers": values.reshape(count, planes, robots), "flags": flags.reshape(count, 2, robots),
        "links": [links[a:z] for a, z in itertools.pairwise(starts)],
    }  # fmt: skip
