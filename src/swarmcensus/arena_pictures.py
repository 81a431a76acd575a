"""Pictures of robots that move, after the paper's Fig. 1: `snapshot` of one tick; `films` puts many together.

Robots are discs to scale, coloured by what they estimate, upon a dimmed floor; lines join those that hear each
other, and a dotted circle is the radio range of one of them. Strokes across a robot say what it no longer does.
"""

from __future__ import annotations

import functools
import textwrap
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import FuncNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.markers import MarkerStyle
from matplotlib.patches import Circle, Patch
from numpy.typing import NDArray

from swarmcensus.errors import InputError
from swarmcensus.floors import floor_of, tiles_across
from swarmcensus.metrics import right_bin
from swarmcensus.origins import setting_of
from swarmcensus.panels import require, truth_of
from swarmcensus.results import load
from swarmcensus.sheets import SMALL, halo
from swarmcensus.traces import replay

SIZE = 6.75, 6.25  # inches: at 128 and 80 dots an inch both are whole, even numbers of dots
LEFT, BOTTOM, ARENA = 0.25, 0.5, 5.1  # inches
WHITE_TILE, BLACK_TILE = 0.97, 0.83  # grey levels: the floor is seen, and robots upon it
ESTIMATES = mpl.colormaps["plasma_r"]  # darker is blacker; its luminance rises evenly, also in grey print
LINEAR = 0.1  # estimates as near as this to the truth, a bin of ten, are told apart best
LINK, RANGE = "#009e73", "#d40000"
STROKES = {"moving": 0.0, "sensing": 45.0, "talking": 135.0}  # degrees: all of a robot's make a star
STROKE = 0.7, 1.7  # where a stroke's two ends begin and end, in radii of a robot: they leave its colour to be seen
LEAST = 0.004  # of the arena's side: smaller robots are drawn with this radius
MOST_TILES = 4000  # from wall to wall; beyond it a floor is even grey
FINE = 1500  # tiles from wall to wall of which each is drawn; of more, means of several are
LINE = 120  # letters in a line of the title


def scene_of(
    results: xr.Dataset | str | Path, setting: int | None = None, trial: int = 0, brain: str | Path | None = None
) -> tuple[xr.Dataset, NDArray[np.uint8] | None]:
    """Return what `snapshot` and `film` draw of one trial: its trace with links, and its floor.

    Takes what `replay` takes; `setting` is by default the first whose robots move. The floor is None where it
    has too many tiles for a picture. Raises InputError, also if the setting's robots do not move.
    """
    data = results if isinstance(results, xr.Dataset) else load(results)
    moving = data["setting"].values[data["topology"].values == "moving"]
    if not moving.size:
        raise InputError('no robots move in these results: arenas and films need topology = "moving"')
    setting = int(moving[0]) if setting is None else setting
    if setting in data["setting"].values and setting not in moving:
        several = ", ".join(map(str, moving[:8])) + (", ..." if moving.size > 8 else "")
        raise InputError(f"setting {setting} is a fixed network, without an arena; those of moving robots: {several}")
    trace = replay(data, setting, trial, brain, links=True)
    study, found = setting_of(data, setting, brain)
    assert found.body is not None
    trace.attrs["tick_seconds"] = found.body.tick
    drawn = tiles_across(trace.attrs["side"], found.body.tile) <= MOST_TILES
    return trace, floor_of(found, study.seed, trial) if drawn else None


def snapshot(
    trace: xr.Dataset, tick: int, floor: NDArray[np.uint8] | None = None, *, robot: int = 0, title: str | None = None
) -> Figure:
    """Draw the arena at the end of a tick: the paper's Fig. 1, with robots coloured by their estimate.

    `trace` is a moving trial's, with links; `floor` holds its tiles (row, column), 1 black, as `floor_of` does:
    squares of `trace.attrs["tile_side"]` metres, the lowest row first, centred upon the arena. Without it the
    floor is the even grey of the fill ratio. Dotted is the radio range of `robot`. Without a `title` it is
    `trace.attrs["title"]`. Robots that by then have failed have a stroke for each thing that they stopped to do.

    Raises InputError if the trace lacks what is drawn, or has no such tick or robot, or the floor is too small.
    """
    arena = Arena(trace, floor, robot=robot, title=title)
    arena.show(tick)
    return arena.figure


class Arena:
    """A moving trial on a figure whose robots `show` puts to where they are at any tick.

    `moving` are the artists that `show` changes, in drawing order; all others stay as they are.
    """

    def __init__(
        self,
        trace: xr.Dataset,
        floor: NDArray[np.uint8] | None,
        *,
        robot: int = 0,
        title: str | None = None,
        note: str = "",
    ) -> None:
        """Draw what stands still, with a `note` under the arena. Raises InputError as `snapshot` does."""
        self._take(trace, robot)
        self.figure = Figure(figsize=SIZE)
        FigureCanvasAgg(self.figure)
        width, height = SIZE
        place = LEFT / width, BOTTOM / height, ARENA / width, ARENA / height
        self.axes = self.figure.add_axes(place, xlim=(-self.half, self.half), ylim=(-self.half, self.half))
        self.axes.set(xticks=[], yticks=[], aspect="equal")
        self.axes.spines[:].set(linewidth=1.6, zorder=6)
        self._draw_floor(floor)
        self._draw_robots()
        self._draw_colours()
        self._draw_scale(note)
        self._draw_key(floor is not None)
        self._write_titles(str(trace.attrs.get("title", "")) if title is None else title)
        self.moving: list[Artist] = [
            self.links,
            self.range,
            self.discs,
            self.headings,
            self.failed,
            self.when,
            self.right,
        ]

    def _take(self, trace: xr.Dataset, robot: int) -> None:
        if "position" not in trace or "side" not in trace.attrs:
            raise InputError("nothing to draw: the trace has no positions, for its robots do not move")
        if "link" not in trace:
            raise InputError("the trace has no links: replay it with links=True")
        require(trace, "estimate", "heading", dimensions=("round", "robot"))
        trace = trace.transpose("part", "round", "robot", "axis", "link", "end", missing_dims="ignore")
        self.ticks = trace["round"].values
        self.position, self.heading = trace["position"].values, trace["heading"].values
        self.estimate = trace["estimate"].values
        links = trace["link"].values
        self.link = links[np.argsort(links[:, 0], kind="stable")]
        self.robots = self.position.shape[1]
        self.stops: dict[str, NDArray[np.int64]] = {}  # of the parts that fail in this trial
        if "stops" in trace:
            first = zip(trace["part"].values.tolist(), trace["stops"].values, strict=True)
            self.stops = {part: ticks for part, ticks in first if (ticks >= 0).any()}
        if not 0 <= robot < self.robots:
            raise InputError(f"robot {robot}: the robots are numbered 0 to {self.robots - 1}")
        self.robot = robot
        self.half = float(trace.attrs["side"]) / 2.0
        self.radius = float(trace.attrs["radius"])
        self.reach, self.tile = float(trace.attrs["radio_range"]), float(trace.attrs["tile_side"])
        self.truth = truth_of(trace)
        self.bins = int(trace.attrs.get("bins", 10))
        self.seconds: float | None = trace.attrs.get("tick_seconds")

    def index(self, tick: int) -> int:
        """Return the place of a tick in the trace. Raises InputError if it is not there."""
        (found,) = np.nonzero(self.ticks == tick)
        if not found.size:
            raise InputError(f"tick {tick}: this trial has ticks {self.ticks[0]} to {self.ticks[-1]}")
        return int(found[0])

    def show(self, tick: int) -> None:
        """Put the robots to where they are at the end of a tick. Raises InputError if the trace lacks it."""
        k = self.index(tick)
        xy, heading, estimate = self.position[k], self.heading[k], self.estimate[k]
        first, last = np.searchsorted(self.link[:, 0], [tick, tick + 1])
        self.links.set_segments(list(xy[self.link[first:last, 1:]]))
        self.range.center = tuple(xy[self.robot])
        self.discs.set_offsets(xy)
        colours = self.colours.to_rgba(np.ma.masked_invalid(estimate))
        self.discs.set(facecolor=colours)
        ahead = self.drawn_radius * np.stack([np.cos(heading), np.sin(heading)], axis=1)
        self.headings.set_segments(list(np.stack([xy + 0.1 * ahead, xy + ahead], axis=1)))
        bright = colours[:, :3] @ (0.2126, 0.7152, 0.0722) > 0.45
        self.headings.set_color(np.where(bright, "black", "white").tolist())
        self.failed.set_segments(self._strokes(xy, tick))
        low, high = right_bin(self.truth, self.bins)
        right = int(((estimate >= low) & (estimate < high)).sum())
        clock = "" if self.seconds is None else f", {tick * self.seconds:,.1f} s"
        self.when.set_text(f"tick {tick:,}{clock}")
        self.right.set_text(f"{right:,} of {self.robots:,}")

    def _strokes(self, xy: NDArray[np.float64], tick: int) -> list[NDArray[np.float64]]:
        """Two lines (end, axis), on opposite sides, for each part of each robot that has stopped by this tick."""
        lines: list[NDArray[np.float64]] = []
        for part, ticks in self.stops.items():
            places = xy[(ticks >= 0) & (ticks <= tick)]
            angle = np.deg2rad(STROKES[part])
            for side in (-1.0, 1.0):
                away = side * self.drawn_radius * np.array([np.cos(angle), np.sin(angle)])
                lines += list(np.stack([places + reach * away for reach in STROKE], axis=1))
        return lines

    def _draw_floor(self, floor: NDArray[np.uint8] | None) -> None:
        if floor is None:
            self.axes.set_facecolor(str(WHITE_TILE + (BLACK_TILE - WHITE_TILE) * self.truth))
            return
        across = np.array(floor.shape[::-1]) * self.tile
        if floor.ndim != 2 or (across < 2.0 * self.half - 1e-6).any():
            raise InputError(
                f"a floor of shape {floor.shape}, in tiles of {self.tile:g} m, does not cover an arena of "
                f"{2.0 * self.half:.2f} m: should be (row, column)"
            )
        step = -(-max(floor.shape) // FINE)
        rows, columns = (np.arange(0, size, step) for size in floor.shape)
        black = np.add.reduceat(np.add.reduceat(floor, rows, axis=0, dtype=np.float32), columns, axis=1)
        black /= np.outer(np.diff([*rows, floor.shape[0]]), np.diff([*columns, floor.shape[1]]))
        left, bottom = -across / 2.0
        self.axes.imshow(
            WHITE_TILE + (BLACK_TILE - WHITE_TILE) * black, cmap="gray", vmin=0.0, vmax=1.0, origin="lower",
            extent=(left, left + columns.size * step * self.tile, bottom, bottom + rows.size * step * self.tile),
        )  # fmt: skip

    def _draw_robots(self) -> None:
        self.drawn_radius = max(self.radius, LEAST * 2.0 * self.half)
        dots = self.drawn_radius / self.half * ARENA / 2.0 * 72.0  # a robot's radius in points
        thin = float(np.clip(0.12 * dots, 0.3, 0.8))
        self.links = LineCollection([], colors=LINK, linewidths=float(np.clip(0.25 * dots, 0.5, 1.3)), zorder=2)
        self.range = Circle((0.0, 0.0), self.reach, fill=False, edgecolor=RANGE, linestyle=":", linewidth=1.6, zorder=3)
        edges = ["black"] * self.robots
        edges[self.robot] = RANGE
        widths = np.full(self.robots, thin)
        widths[self.robot] = 2.0 * thin
        size = 2.0 * self.drawn_radius
        self.discs = EllipseCollection(
            size, size, 0.0, units="xy", offsets=np.zeros((self.robots, 2)), offset_transform=self.axes.transData,
            edgecolors=edges, linewidths=widths, zorder=4,
        )  # fmt: skip
        self.headings = LineCollection([], linewidths=2.0 * thin, zorder=5, capstyle="butt")
        wide = float(np.clip(0.3 * dots, 1.0, 2.2))
        self.failed = LineCollection([], colors="black", linewidths=wide, zorder=7, path_effects=halo(2.0 * wide))
        for collection in (self.links, self.discs, self.headings, self.failed):
            self.axes.add_collection(collection, autolim=False)
        self.axes.add_patch(self.range)

    def _draw_colours(self) -> None:
        far = max(self.truth, 1.0 - self.truth)
        most = np.arcsinh(far / LINEAR)
        # Odd about the truth, with the scale's middle there: equal errors are equally far from its colour.
        norm = FuncNorm(
            (
                lambda x: np.arcsinh((np.asarray(x) - self.truth) / LINEAR) / most,
                lambda y: self.truth + LINEAR * np.sinh(np.asarray(y) * most),
            ),
            vmin=self.truth - far,
            vmax=self.truth + far,
        )
        self.colours = ScalarMappable(norm, ESTIMATES.with_extremes(bad="0.6"))
        width, height = SIZE
        axes = self.figure.add_axes(
            ((LEFT + ARENA + 0.2) / width, (BOTTOM + 2.15) / height, 0.16 / width, 2.6 / height)
        )
        low, truth, high = (float(norm(x)) for x in (0.0, self.truth, 1.0))
        edges = np.linspace(low, high, 257)
        strip = self.colours.to_rgba(norm.inverse((edges[1:] + edges[:-1]) / 2.0))
        axes.imshow(strip[:, np.newaxis], origin="lower", aspect="auto", extent=(0.0, 1.0, low, high))
        ticks = {float(norm(x)): f"{x:g}" for x in (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)}
        ticks = {y: text for y, text in ticks.items() if abs(y - truth) > 0.07 * (high - low)}  # room for its name
        axes.yaxis.tick_right()
        axes.set_xticks([])
        axes.set_yticks(list(ticks), list(ticks.values()), fontsize=SMALL)
        axes.axhline(truth, color="black", linewidth=1.2)
        axes.annotate(
            f"true f = {self.truth:.4g}", (1.0, truth), (5, 0), textcoords="offset points", va="center",
            fontsize=SMALL, fontweight="bold", annotation_clip=False,
        )  # fmt: skip
        axes.set_title("estimated\nfill ratio", loc="left", fontsize=SMALL)

    def _write_titles(self, title: str) -> None:
        lines = textwrap.wrap(title, LINE)[:2]
        width, height = SIZE
        left, right, y = LEFT / width, (LEFT + ARENA) / width, (BOTTOM + ARENA + 0.19 + 0.13 * len(lines)) / height
        # What others have called a study is text, also where it has dollar signs.
        write = functools.partial(self.figure.text, va="baseline", parse_math=False)
        write(left, (BOTTOM + ARENA + 0.12) / height, "\n".join(lines), fontsize=SMALL, va="bottom")
        self.when = write(left, y, "", fontsize=SMALL + 3)
        # Letters are what takes longest to draw in a film: those that stay are not written again.
        most = f"{self.robots:,} of {self.robots:,}"
        start = right - 0.08 * len(most) / width
        write(start - 0.05 / width, y, "robots in the right bin:", fontsize=SMALL + 3, ha="right")
        self.right = write(start, y, "", fontsize=SMALL + 3)

    def _draw_scale(self, note: str) -> None:
        length = max(m * 10.0**e for m in (1, 2, 5) for e in range(-3, 6) if m * 10.0**e <= 0.6 * self.half)
        y = -self.half * (1.0 + 2.0 * 0.14 / ARENA)
        x = -self.half, -self.half + length
        self.axes.plot(x, [y, y], "|-", color="black", linewidth=1.2, markersize=6, clip_on=False)
        self.axes.text(
            x[1] + 0.03 * self.half, y, f"{length:g} m" if length >= 0.01 else f"{1000 * length:g} mm",
            va="center", fontsize=SMALL,
        )  # fmt: skip
        self.axes.text(self.half, y, note, ha="right", va="center", fontsize=SMALL)

    def _draw_key(self, tiles: bool) -> None:
        grey = str(WHITE_TILE), str(BLACK_TILE)
        enlarged = self.drawn_radius > self.radius
        disc = Line2D([], [], linestyle="", marker="o", markersize=7, color=ESTIMATES(0.5), markeredgecolor="black")
        entries: dict[str, Any] = {
            "robot, heading" + ("\n(not to scale)" if enlarged else ""): disc,
            "radio link": Line2D([], [], color=LINK, linewidth=1.3),
            f"radio range of\nrobot {self.robot}": Line2D([], [], color=RANGE, linestyle=":", linewidth=1.6),
        }
        for part in self.stops:
            mark = MarkerStyle("_").rotated(deg=STROKES[part])
            stroke = Line2D([], [], linestyle="", marker=mark, markersize=13, markeredgewidth=1.6, color="black")
            entries[f"stopped {part}"] = stroke, disc
        if tiles:
            entries["black tile"] = Patch(facecolor=grey[1], edgecolor="0.5", linewidth=0.5)
            entries["white tile"] = Patch(facecolor=grey[0], edgecolor="0.5", linewidth=0.5)
        width, height = SIZE
        self.figure.legend(
            list(entries.values()), list(entries), loc="lower left", frameon=False, fontsize=SMALL, borderaxespad=0,
            bbox_to_anchor=((LEFT + ARENA + 0.14) / width, BOTTOM / height), handlelength=1.5, labelspacing=0.7,
        )  # fmt: skip
