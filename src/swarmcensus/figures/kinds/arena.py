"""Where robots that move are at one tick, what they estimate, and who hears whom."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray

from swarmcensus.basics.bins import right_bin
from swarmcensus.basics.errors import InputError
from swarmcensus.figures import scenes
from swarmcensus.figures.arena_margins import (
    ARENA,
    BLACK_TILE,
    BOTTOM,
    LEFT,
    LINK,
    RANGE,
    SIZE,
    STROKES,
    WHITE_TILE,
    Room,
    draw_colours,
    draw_key,
    draw_scale,
    room_in,
    write_titles,
)
from swarmcensus.figures.clouds import truth_of, truths_of
from swarmcensus.figures.looks import LIES, halo
from swarmcensus.figures.scenes import ChangingFloor, Tiles, check_robot, scene_of
from swarmcensus.figures.sheets import Drawn, Own, drawn_on, own_axes
from swarmcensus.results.replaying import honest_in
from swarmcensus.results.selecting import require


def arena(
    results: xr.Dataset,
    *,
    setting: int | None = None,
    trial: int = 0,
    brain: str | Path | None = None,
    tick: int | str | None = None,
    robot: int = 0,
    title: str | None = None,
    ax: Own = None,
) -> Drawn:
    """Draw the arena at the end of a tick, or at a time as "5 min": by default the last. The paper's Fig. 1.

    `results` are a study's: then `setting` (by default the first whose robots move) and `trial` are replayed, with the
    file `brain` where the brain is one of your own. Or it is a trace of `sc.replay` with links: then the floor is the
    even grey of the fill ratio. Robots are discs to scale, coloured by what they estimate; lines join those that hear
    each other, a dotted circle is the radio range of `robot`, and strokes across a robot say what it no longer does.
    Axes of your own, `ax`, become square; the key stands under them.

    Raises InputError if there is no such setting, trial, tick or robot, or robots do not move.
    """
    clock = scenes.clock_of(results, setting, trial, brain, robot)
    at = clock.last if tick is None else clock.tick(tick, "tick")
    scenes.check_tick(at, (clock.first, clock.last))
    trace, floor = scenes.drawn_of(results, setting, trial, brain)
    return snapshot(trace, at, floor, robot=robot, title=title, ax=ax)


__all__ = ["Arena", "scene_of", "snapshot"]

STROKE = 0.7, 1.7  # where a stroke's two ends begin and end, in radii of a robot: they leave its colour to be seen
LEAST = 0.004  # of the arena's side: smaller robots are drawn with this radius
FINE = 1500  # tiles from wall to wall of which each is drawn; of more, means of several are


def snapshot(
    trace: xr.Dataset,
    tick: int,
    floor: Tiles = None,
    *,
    robot: int = 0,
    title: str | None = None,
    ax: Own = None,
) -> Drawn:
    """Draw the arena at the end of a tick: the paper's Fig. 1, with robots coloured by their estimate.

    `trace` is a moving trial's, with links; `floor` holds its tiles (row, column), 1 black, as `Ground.all_tiles` does:
    squares of `trace.attrs["tile_side"]` metres, the lowest row first, centred upon the arena. Without it the
    floor is the even grey of the fill ratio. Of one that changes, floor and truth are those of the tick. Dotted is
    the radio range of `robot`. Without a `title` it is `trace.attrs["title"]`. Robots that by then have failed have a
    stroke for each thing that they stopped to do.

    Raises InputError if the trace lacks what is drawn, or has no such tick or robot, or the floor is too small.
    """
    arena = Arena(trace, floor, robot=robot, title=title, ax=ax)
    arena.show(tick)
    return drawn_on([arena.axes], ax)


def _new_axes() -> Axes:
    """Those of an arena on a new figure, with margins for what stands around it."""
    figure = Figure(figsize=SIZE)
    FigureCanvasAgg(figure)
    width, height = SIZE
    return figure.add_axes((LEFT / width, BOTTOM / height, ARENA / width, ARENA / height))


class Arena:
    """A moving trial on a figure whose robots `show` puts to where they are at any tick.

    `moving` are the artists that `show` changes, in drawing order; all others stay as they are.
    """

    def __init__(
        self,
        trace: xr.Dataset,
        floor: Tiles,
        *,
        robot: int = 0,
        title: str | None = None,
        note: str = "",
        ax: Own = None,
    ) -> None:
        """Draw what stands still, with a `note` under the arena. Raises InputError as `snapshot` does."""
        self._take(trace, robot)
        self.axes = _new_axes() if ax is None else own_axes(ax, 1, "an arena is one panel")[0]
        self.axes.set(xlim=(-self.half, self.half), ylim=(-self.half, self.half), xticks=[], yticks=[], aspect="equal")
        self.figure: Any = self.axes.figure.canvas.figure
        self.room = Room() if ax is None else room_in(self.axes)
        self.axes.spines[:].set(linewidth=1.6, zorder=6)
        self.floor = floor
        self._draw_floor()
        self._draw_robots()
        self.colours, self.bar = draw_colours(self.axes, self.room, self.truth)
        draw_scale(self.axes, self.room, self.half, note)
        to_scale = self.drawn_radius == self.radius
        draw_key(
            self.axes, self.room, self.robot, list(self.stops), to_scale=to_scale, tiles=floor is not None,
            liars=not self.honest.all(),
        )  # fmt: skip
        name = str(trace.attrs.get("title", "")) if title is None else title
        self.when, self.right = write_titles(self.axes, self.room, name, self.robots)
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
        first = "edge", "fault", "part", "round", "robot", "axis", "link", "end"
        trace = trace.transpose(*first, ..., missing_dims="ignore")
        self.ticks = trace["round"].values
        self.position, self.heading = trace["position"].values, trace["heading"].values
        self.estimate = trace["estimate"].values
        self.honest = honest_in(trace)
        links = trace["link"].values
        self.link = links[np.argsort(links[:, 0], kind="stable")]
        self.robots = self.position.shape[1]
        self.stops = _spells(trace) if "stops" in trace else {}
        check_robot(robot, self.robots)
        self.robot = robot
        self.half = float(trace.attrs["side"]) / 2.0
        self.radius = float(trace.attrs["radius"])
        self.reach, self.tile = float(trace.attrs["radio_range"]), float(trace.attrs["tile_side"])
        self.truths = truths_of(trace)
        self.truth = truth_of(trace) if self.truths is None else float(self.truths[0])
        self.bins = int(trace.attrs.get("bins", 10))
        self.seconds: float | None = trace.attrs.get("tick_seconds")

    def index(self, tick: int) -> int:
        """Return the place of a tick in the trace. Raises InputError if it is not there."""
        (found,) = np.nonzero(self.ticks == tick)
        if not found.size:
            raise InputError(f"tick {tick}: this trial has ticks {self.ticks[0]:,} to {self.ticks[-1]:,}")
        return int(found[0])

    def paint(self, tick: int) -> bool:
        """Show the floor and the truth of a tick, where they change; whether they are others than those shown."""
        if self.truths is None or self.truths[self.index(tick)] == self.truth:
            return False
        self.truth = float(self.truths[self.index(tick)])
        self.bar.remove()
        self.colours, self.bar = draw_colours(self.axes, self.room, self.truth)
        if isinstance(self.floor, ChangingFloor):
            self.image.set_data(self._greys(self.floor.at(tick)))
        elif self.floor is None:
            self._draw_floor()
        return True

    def show(self, tick: int) -> None:
        """Put the robots to where they are at the end of a tick. Raises InputError if the trace lacks it."""
        k = self.index(tick)
        self.paint(tick)
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
        right = int(((estimate >= low) & (estimate < high) & self.honest).sum())
        clock = "" if self.seconds is None else f", {tick * self.seconds:,.1f} s"
        self.when.set_text(f"tick {tick:,}{clock}")
        self.right.set_text(f"{right:,} of {self.honest.sum():,}" + " honest ones" * (not self.honest.all()))

    def _strokes(self, xy: NDArray[np.float64], tick: int) -> list[NDArray[np.float64]]:
        """Two lines (end, axis), on opposite sides, for each part of each robot that does not work in this tick."""
        lines: list[NDArray[np.float64]] = []
        for part, (since, until) in self.stops.items():
            places = xy[((since >= 0) & (since <= tick) & ((until < 0) | (tick < until))).any(axis=0)]
            angle = np.deg2rad(STROKES[part])
            for side in (-1.0, 1.0):
                away = side * self.drawn_radius * np.array([np.cos(angle), np.sin(angle)])
                lines += list(np.stack([places + reach * away for reach in STROKE], axis=1))
        return lines

    def _draw_floor(self) -> None:
        if self.floor is None:
            self.axes.set_facecolor(str(WHITE_TILE + (BLACK_TILE - WHITE_TILE) * self.truth))
            return
        floor = self.floor.tiles if isinstance(self.floor, ChangingFloor) else self.floor
        across = np.array(floor.shape[::-1]) * self.tile
        if floor.ndim != 2 or (across < 2.0 * self.half - 1e-6).any():
            raise InputError(
                f"a floor of shape {floor.shape}, in tiles of {self.tile:g} m, does not cover an arena of "
                f"{2.0 * self.half:.2f} m: should be (row, column)"
            )
        greys, step = self._greys(floor), -(-max(floor.shape) // FINE)
        left, bottom = -across / 2.0
        wide, high = (size * step * self.tile for size in greys.shape[::-1])
        self.image = self.axes.imshow(
            greys, cmap="gray", vmin=0.0, vmax=1.0, origin="lower", extent=(left, left + wide, bottom, bottom + high)
        )

    def _greys(self, floor: NDArray[np.uint8]) -> NDArray[np.float32]:
        """How tiles are drawn, or the means of several."""
        step = -(-max(floor.shape) // FINE)
        rows, columns = (np.arange(0, size, step) for size in floor.shape)
        black = np.add.reduceat(np.add.reduceat(floor, rows, axis=0, dtype=np.float32), columns, axis=1)
        black /= np.outer(np.diff([*rows, floor.shape[0]]), np.diff([*columns, floor.shape[1]]))
        return np.asarray(WHITE_TILE + (BLACK_TILE - WHITE_TILE) * black)

    def _draw_robots(self) -> None:
        self.drawn_radius = max(self.radius, LEAST * 2.0 * self.half)
        dots = self.drawn_radius / self.half * self.room.side / 2.0 * 72.0  # a robot's radius in points
        thin = float(np.clip(0.12 * dots, 0.3, 0.8))
        self.links = LineCollection([], colors=LINK, linewidths=float(np.clip(0.25 * dots, 0.5, 1.3)), zorder=2)
        self.range = Circle((0.0, 0.0), self.reach, fill=False, edgecolor=RANGE, linestyle=":", linewidth=1.6, zorder=3)
        edges = np.where(self.honest, "black", LIES).tolist()
        if self.honest[self.robot]:  # of a liar that ring says more, and the circle of its range whose it is
            edges[self.robot] = RANGE
        widths = np.where(self.honest, thin, 2.5 * thin)
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


def _spells(trace: xr.Dataset) -> dict[str, tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """When parts that fail in this trial stop, and when they work again, (fault, robot) each; -1: never."""
    parts, first = trace["part"].values.tolist(), trace["stops"].values
    never = np.full((1, *first.shape), -1)
    since, until = trace["outages"].values if "outages" in trace else (first[np.newaxis], never)
    return {part: (since[:, k], until[:, k]) for k, part in enumerate(parts) if (first[k] >= 0).any()}
