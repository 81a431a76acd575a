"""Studies that run on clusters, and whether their results are the same."""

from pathlib import Path

import swarmcensus as sc

LONG = """
name = "long"
seed = 9
trials = 200
swarm = {robots = 100, accuracy = [0.6, 0.7]}
world = {topology = ["ring", "line"], fill_ratio = 0.55}
schedule = {rounds = 1000}
"""


def study(text):
    return sc.Study.parse(text, context={"base": Path.cwd()})


class Once:
    """A progress callback that does something once, when some trials are done and others are not."""

    def __init__(self, act):
        self.act, self.done = act, False

    def __call__(self, progress):
        if not self.done and 0 < progress.done < progress.total:
            self.done = True
            self.act()
