"""Draws fifteen floors that all are black to 55 percent: python floors.py, next to floors.toml."""

from pathlib import Path

from matplotlib.figure import Figure

import swarmcensus as sc
from swarmcensus.simulation import sampling

study = sc.Study.load(Path(__file__).with_name("floors.toml"))
names = ["random", "stripe", "block", "off-diagonal", "star", "band", "bandwidth", "bandwidth-r", "band-stripe"]
world = {"topology": "moving", "density": 10, "fill_ratio": 0.55, "floor": [{"benchmark": name} for name in names]}
figure = Figure(figsize=(11, 7.2), layout="constrained")
settings = [*study.settings(), *study.with_(world=world).settings()]
for panel, setting in zip(figure.subplots(3, 5).flat, settings, strict=True):
    tiles = sampling.ground(setting, study.seed, trial=0).all_tiles()
    panel.imshow(1 - tiles, cmap="gray", origin="lower", interpolation="nearest")
    panel.set_title(str(setting.floor))
    panel.set(xticks=[], yticks=[])
figure.savefig("floors.png", dpi=80)
