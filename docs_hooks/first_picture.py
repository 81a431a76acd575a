"""The film of the first page: one swarm with two brains among liars, on light and on dark pages.

python docs_hooks/first_picture.py       # writes docs/images/agree.gif and agree-dark.gif
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from PIL import Image

import swarmcensus as sc
from swarmcensus.figures.arena_margins import BLACK_TILE, ESTIMATES, LINK, WHITE_TILE
from swarmcensus.figures.one_trial import FLOOR, scene_of

ROOT = Path(__file__).parents[1]
EVERY, PAUSE = 15, 180  # ticks from frame to frame, and the milliseconds that each is shown
LAST = 3000  # milliseconds of the last frame
RIGHT = 0.1  # an estimate counts as right within this distance of the truth
FARTHEST = 0.4  # the distance that has the darkest colour
PAGES = {"agree": ("#ffffff", "#1f2328"), "agree-dark": ("#0d1117", "#e6edf3")}  # paper and ink
DOTS = 100  # per inch; 780 dots across are as wide as the README
SIDE, EDGE, GAP, UNDER, OVER = 3.8, 0.04, 0.12, 0.44, 0.42  # inches
SIZE = 2 * SIDE + GAP + 2 * EDGE, SIDE + UNDER + OVER


class Arena:
    """One trial on its axes; `show` moves its robots to where they are at a tick."""

    def __init__(self, axes: Axes, trace: xr.Dataset, ink: str) -> None:
        """Draw the floor and the robots."""
        self.trace, self.axes, self.ink = trace, axes, ink
        half, radius = trace.attrs["side"] / 2.0, trace.attrs["radius"]
        floor = WHITE_TILE + (BLACK_TILE - WHITE_TILE) * trace[FLOOR].values
        axes.imshow(floor, cmap="gray", vmin=0, vmax=1, origin="lower", extent=(-half, half, -half, half))
        axes.set(xticks=[], yticks=[])
        axes.spines[:].set_color(ink)
        offsets: dict[str, Any] = {"offsets": trace["position"].values[0], "offset_transform": axes.transData}
        size = 2.3 * radius
        self.discs = EllipseCollection(size, size, 0, units="xy", edgecolors="black", linewidths=1, zorder=3, **offsets)
        self.links = LineCollection([], colors=LINK, linewidths=2, zorder=2)
        self.crosses = LineCollection([], colors="black", linewidths=2.4, zorder=4)
        for collection in (self.discs, self.links, self.crosses):
            axes.add_collection(collection, autolim=False)

    def show(self, tick: int) -> None:
        """Move the robots."""
        trace, honest = self.trace, self.trace["honest"].values == 1
        xy = trace["position"].values[tick]
        off = trace["estimate"].values[tick] - trace.attrs["true_fill_ratio"]
        links = trace["link"].values
        self.discs.set(offsets=xy, facecolor=ESTIMATES(Normalize(-FARTHEST, FARTHEST)(off)))
        self.links.set_segments(list(xy[links[links[:, 0] == tick, 1:]]))
        arm = 0.75 * trace.attrs["radius"]
        ends = np.array([[(-arm, -arm), (arm, arm)], [(-arm, arm), (arm, -arm)]])
        self.crosses.set_segments(list((xy[~honest, None, None] + ends).reshape(-1, 2, 2)))
        right = int((np.abs(off[honest]) < RIGHT).sum())
        title = f"{trace.attrs['brain']}: {right} of {int(honest.sum())} right"
        self.axes.set_title(title, color=self.ink, fontsize=19, pad=7)


def draw() -> None:
    """Run the study, and write its two trials next to each other."""
    results = sc.run(sc.Study.load(ROOT / "studies" / "agree.toml"))
    traces = [scene_of(results, setting) for setting in results["setting"].values]
    for name, (paper, ink) in PAGES.items():
        frames = list(drawn(traces, paper, ink))
        pauses = [PAUSE] * (len(frames) - 1) + [LAST]
        path = ROOT / "docs" / "images" / f"{name}.gif"
        frames[0].save(path, save_all=True, append_images=frames[1:], duration=pauses, loop=0, optimize=True)


def drawn(traces: list[xr.Dataset], paper: str, ink: str) -> Iterator[Image.Image]:
    """Each frame, all with the colours of one palette."""
    width, height = SIZE
    figure = Figure(SIZE, dpi=DOTS, facecolor=paper)
    canvas = FigureCanvasAgg(figure)
    places = [(EDGE + k * (SIDE + GAP)) / width for k in range(2)]
    arenas = [
        Arena(figure.add_axes((x, UNDER / height, SIDE / width, SIDE / height)), trace, ink)
        for x, trace in zip(places, traces, strict=True)
    ]
    bar = figure.add_axes((0.31, 0.09 / height, 0.32, 0.27 / height))
    colours = ScalarMappable(Normalize(-FARTHEST, FARTHEST), ESTIMATES)
    figure.colorbar(colours, cax=bar, orientation="horizontal", ticks=[]).outline.set_edgecolor(ink)
    letters: dict[str, Any] = {"fontsize": 16, "va": "center_baseline"}
    level = 0.22 / height
    figure.text(0.3, level, "too low", ha="right", color=ink, **letters)
    figure.text(0.47, level, "true", ha="center", color="black", **letters)
    figure.text(0.64, level, "too high", color=ink, **letters)
    figure.text(1 - EDGE / width, level, "×  liar", ha="right", color=ink, **letters)
    clock = figure.text(EDGE / width, level, "", color=ink, **letters)
    palette = palette_of(paper, ink)
    for tick in range(1, traces[0].sizes["round"], EVERY):
        for arena in arenas:
            arena.show(tick)
        clock.set_text(f"{tick * traces[0].attrs['tick_seconds']:.0f} s")
        canvas.draw()
        frame = Image.frombuffer("RGBA", canvas.get_width_height(), canvas.buffer_rgba()).convert("RGB")
        yield frame.quantize(palette=palette, dither=Image.Dither.NONE)


def palette_of(paper: str, ink: str) -> Image.Image:
    """A picture that holds the colours of robots, tiles, links and letters, and what lies between two of them."""
    tiles = [str(WHITE_TILE), str(BLACK_TILE)]
    mixed = [(paper, ink), (ink, tiles[0]), (ink, tiles[1]), (LINK, tiles[0]), (LINK, tiles[1]), ("black", tiles[0])]
    ramps = [LinearSegmentedColormap.from_list("mixed", ends)(np.linspace(0, 1, 8)) for ends in mixed]
    colours = np.concatenate([ESTIMATES(np.linspace(0, 1, 48)), *ramps])
    palette = Image.new("P", (1, 1))
    palette.putpalette((255 * colours[:, :3]).round().astype(np.uint8).tobytes())
    return palette


if __name__ == "__main__":
    draw()
