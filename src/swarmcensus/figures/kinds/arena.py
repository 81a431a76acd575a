"""Picture of one trial at one moment: positions, estimates and links of robots that move, or of a fixed network."""

from __future__ import annotations

from typing import Any, Unpack

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray

from swarmcensus.figures import one_trial
from swarmcensus.figures.arena_margins import (
    BLACK_TILE,
    LINK,
    RANGE,
    STROKES,
    WHITE_TILE,
    draw_colours,
    draw_opinions,
    draw_scale,
    key_entries,
    write_headline,
)
from swarmcensus.figures.captions import captioned
from swarmcensus.figures.groups import truth_of, truths_of
from swarmcensus.figures.one_trial import FLOOR, TURNS, check_robot
from swarmcensus.figures.page import PageOptions, on_page
from swarmcensus.figures.sheets import add_key, figure_of, sheet
from swarmcensus.figures.styles import halo
from swarmcensus.results import Brains
from swarmcensus.summaries import honest_in, require
from swarmcensus.support.bins import right_bin
from swarmcensus.support.errors import InputError
from swarmcensus.support.options import wrong_option

STROKE = 0.7, 1.7  # ends of the strokes across a failed robot, in radii from its centre: its colour stays visible
SIDE, AROUND = 4.6, 0.9  # inches: of the arena, and for what is on its left and its right
LEAST = 0.004  # the smallest drawn radius of a robot, as a share of the arena's side


@on_page
def arena(
    results: xr.Dataset,
    *,
    setting: int | None = None,
    trial: int = 0,
    brain_file: Brains = (),
    tick: int | str | None = None,
    robot: int = 0,
    title: str | None = None,
    **more: Unpack[PageOptions],
) -> Figure:
    """Draw the arena with its moving robots at the end of a tick, or the robots of a fixed network after a round.

    The paper's Fig. 1 is such a picture. Robots are discs to scale, coloured by their estimates, or black and white by
    their opinions, with their heading. Lines join robots that hear each other. A dashed circle is the radio range of
    one robot. Strokes across a robot show what it has stopped doing.

    - `results`: a study's results, of which one trial is then replayed, or a trace from `sc.replay` with links. Such a
      trace has no tiles, so its floor is the grey of the fill ratio.
    - `setting`, `trial`: the trial to replay; by default the first trial of the first setting with robots that move, or
      else of the first setting.
    - `brain_file`: the files of brains, adversaries and metrics of your own to replay with: one, or several.
    - `tick`: a tick, or a time such as "5 min"; by default the last tick.
    - `robot`: the radio range of this robot is drawn.
    - `title`: the title of the figure; by default `trace.attrs["title"]`.
    - `width`, `height`, `font_size`, `labels`: the page, and names of brains (see `PageOptions`).

    Raises InputError if there is no such setting, trial, tick or robot, and if a trace does not say where robots are.
    """
    clock = one_trial.clock_of(results, setting, trial, brain_file, robot)
    drawn_tick = clock.last if tick is None else clock.tick(tick, "tick")
    drawn = Arena(one_trial.drawn_of(results, setting, trial, brain_file), robot=robot, title=title)
    drawn.show(drawn_tick)
    return captioned([drawn.axes], arena, more=drawn.sentences())


class Arena:
    """A trial on a figure. `show` moves the robots to their positions at a tick.

    `moving` are the artists that `show` changes, in drawing order. All others stay as they are.
    """

    def __init__(self, trace: xr.Dataset, *, robot: int = 0, title: str | None = None) -> None:
        """Draw everything of a trace that does not move.

        The trace has links, and perhaps a floor (see `one_trial.scene_of`); without it the floor is the grey of the
        fill ratio. Raises InputError if it lacks a variable or the robot, and if the floor does not cover the arena.
        """
        self._read(trace, robot)
        self.name = str(trace.attrs.get("title", "")) if title is None else title
        [self.axes] = sheet([self.name], None, shape=(SIDE, SIDE), left=AROUND)
        self.axes.set(xlim=(-self.half, self.half), ylim=(-self.half, self.half), xticks=[], yticks=[], aspect="equal")
        self.axes.set_anchor("SW")
        self.axes.apply_aspect()
        self.figure: Any = figure_of([self.axes])
        self.axes.spines[:].set(linewidth=1.6, zorder=6)
        self._draw_floor()
        self._draw_robots()
        self._draw_colours()
        if self.moves:
            draw_scale(self.axes, self.half)
        counted = "opinions:" if self.opinions else "robots in the right bin:"
        self.when, self.right = write_headline(self.axes, counted, self._counts(self.robots, self.robots))
        entries = key_entries(
            self.robot if self.moves else None, list(self.stops), to_scale=self.drawn_radius == self.radius,
            tiles=self.floor is not None, liars=not self.honest.all(),
        )  # fmt: skip
        add_key([self.axes], "", entries)
        self.figure.set_gid("arena")  # lines are to the scale of robots, on slides too
        self.moving: list[Artist] = [self.links, self.range] if self.moves else []
        self.moving += [self.discs, self.headings, self.crosses, self.failed, self.when, self.right]

    def _read(self, trace: xr.Dataset, robot: int) -> None:
        """Take the arrays and sizes from the trace. Raises InputError if it lacks some."""
        if "position" not in trace or "side" not in trace.attrs:
            why = "draw a fixed network from results, with setting and trial; robots' logs do not say where they were"
            raise InputError(f"nothing to draw: the trace has no positions: {why}")
        if "link" not in trace:
            raise InputError("the trace has no links: replay it with links=True", key="links")
        require(trace, "estimate", dimensions=("round", "robot"))
        first = "edge", "fault", "part", "round", "robot", "axis", "link", "end", "row", "column"
        trace = trace.transpose(*first, ..., missing_dims="ignore")
        self.ticks = trace["round"].values
        self.moves, self.position = "heading" in trace, trace["position"].values
        self.heading = trace["heading"].values if self.moves else np.full(trace["estimate"].shape, np.nan)
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
        self.reach, self.tile = (float(trace.attrs.get(name, 0.0)) for name in ("radio_range", "tile_side"))
        self.truths = truths_of(trace)
        self.truth = truth_of(trace) if self.truths is None else float(self.truths[0])
        self.bins, self.opinions = int(trace.attrs.get("bins", 10)), bool(trace.attrs.get("opinions", False))
        self.seconds: float | None = trace.attrs.get("tick_seconds")
        self.unit = "tick" if self.moves else "round"
        self.floor: NDArray[np.uint8] | None = trace[FLOOR].values if FLOOR in trace else None
        self.turns: NDArray[np.int32] | None = trace[TURNS].values if TURNS in trace else None

    def index(self, tick: int) -> int:
        """Return the index of a tick in the trace. Raises InputError if the trace lacks it."""
        (indices,) = np.nonzero(self.ticks == tick)
        if not indices.size:
            raise wrong_option("tick", tick, f"this trial has ticks {self.ticks[0]:,} to {self.ticks[-1]:,}")
        return int(indices[0])

    def sentences(self) -> list[str]:
        """What a caption says of the tick that is shown."""
        says, counts = f"{self.robots:,} robots at {self.when.get_text()}", self.right.get_text()
        if self.opinions:
            return [f"{says}: {counts}.", f"Colours are opinions; the fill ratio is {self.truth:.4g}."]
        colours = (
            f"Colours are estimates of the fill ratio, here {self.truth:.4g}; their scale is not linear, but finest"
        )
        return [f"{says}, of which {counts} are in the right bin.", f"{colours} there."]

    def paint(self, tick: int) -> bool:
        """Draw the floor and the true fill ratio of a tick. Returns whether they differ from those drawn before."""
        if self.truths is None or self.truths[self.index(tick)] == self.truth:
            return False
        self.truth = float(self.truths[self.index(tick)])
        self.bar.remove()
        self._draw_colours()
        if self.floor is None:
            self._draw_floor()
        elif self.turns is not None:
            self.image.set_data(self._greys(self.floor ^ (tick >= self.turns)))
        return True

    def show(self, tick: int) -> None:
        """Move the robots to their positions at the end of a tick. Raises InputError if the trace lacks it."""
        k = self.index(tick)
        self.paint(tick)
        xy, heading, estimate = self.position[k], self.heading[k], self.estimate[k]
        first, last = np.searchsorted(self.link[:, 0], [tick, tick + 1]) if self.moves else (0, len(self.link))
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
        around = self.drawn_radius * np.sqrt(0.5) * np.array([[-1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [1.0, -1.0]])
        ends = xy[~self.honest, np.newaxis] + around
        self.crosses.set_segments(list(ends.reshape(-1, 2, 2)))
        clock = "" if self.seconds is None else f", {tick * self.seconds:,.1f} s"
        self.when.set_text(f"{self.unit} {tick:,}{clock}")
        honest, (low, high) = estimate[self.honest], right_bin(self.truth, self.bins)
        first = honest == 1.0 if self.opinions else (honest >= low) & (honest < high)
        second = (honest == 0.0).sum() if self.opinions else honest.size
        self.right.set_text(self._counts(int(first.sum()), int(second)) + " honest ones" * (not self.honest.all()))

    def _counts(self, first: int, second: int) -> str:
        """How many robots have either opinion, or are in the right bin."""
        return f"{first:,} black, {second:,} white" if self.opinions else f"{first:,} of {second:,}"

    def _draw_colours(self) -> None:
        if self.opinions:
            self.colours, self.bar = draw_opinions(self.axes)
        else:
            self.colours, self.bar = draw_colours(self.axes, self.truth)

    def _strokes(self, xy: NDArray[np.float64], tick: int) -> list[NDArray[np.float64]]:
        """Two lines (end, axis), on opposite sides of the robot, for each failed part of each robot in this tick."""
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
            self.axes.set_facecolor(str(WHITE_TILE + (BLACK_TILE - WHITE_TILE) * self.truth) if self.moves else "white")
            return
        floor = self.floor
        across = np.array(floor.shape[::-1]) * self.tile
        if (across < 2.0 * self.half - 1e-6).any():
            size = f"of shape {floor.shape}, in tiles of {self.tile:g} m,"
            raise InputError(f"a floor {size} does not cover an arena of {2.0 * self.half:.2f} m")
        wide, high = across / 2.0
        extent, greys = (-wide, wide, -high, high), self._greys(floor)
        self.image = self.axes.imshow(greys, cmap="gray", vmin=0.0, vmax=1.0, origin="lower", extent=extent)

    def _greys(self, floor: NDArray[np.uint8]) -> NDArray[np.float32]:
        """The grey levels of tiles."""
        return np.asarray(WHITE_TILE + (BLACK_TILE - WHITE_TILE) * floor.astype(np.float32))

    def _draw_robots(self) -> None:
        self.drawn_radius = max(self.radius, LEAST * 2.0 * self.half)
        points = 72.0 * self.axes.bbox.width / self.figure.dpi
        dots = self.drawn_radius / self.half * points / 2.0  # a robot's radius in points
        thin = float(np.clip(0.12 * dots, 0.3, 0.8))
        wide = float(np.clip(0.25 * dots, 0.7, 1.3)) if self.moves else min(1.3, 300.0 / (len(self.link) + 1))
        self.links = LineCollection([], colors=LINK, linewidths=wide, path_effects=halo(wide + 1.4 * self.moves))
        self.range = Circle(
            (0.0, 0.0), self.reach, fill=False, edgecolor=RANGE, linestyle="--", linewidth=1.6, zorder=3,
            path_effects=halo(3.2),
        )  # fmt: skip
        widths = np.full(self.robots, thin)
        widths[self.robot] *= 3.0 if self.moves else 1.0
        size = 2.0 * self.drawn_radius
        self.discs = EllipseCollection(
            size, size, 0.0, units="xy", offsets=np.zeros((self.robots, 2)), offset_transform=self.axes.transData,
            edgecolors="black", linewidths=widths, zorder=4, path_effects=halo(3.0 if self.moves else 1.0),
        )  # fmt: skip
        self.headings = LineCollection([], linewidths=2.0 * thin, zorder=5, capstyle="butt")
        wide = float(np.clip(0.3 * dots, 1.0, 2.2))
        stroke: dict[str, Any] = {"colors": "black", "linewidths": wide, "path_effects": halo(2.0 * wide)}
        self.crosses, self.failed = LineCollection([], zorder=6, **stroke), LineCollection([], zorder=7, **stroke)
        for collection in (self.links, self.discs, self.headings, self.crosses, self.failed):
            self.axes.add_collection(collection, autolim=False)
        self.axes.add_patch(self.range).set_visible(self.moves)


def _spells(trace: xr.Dataset) -> dict[str, tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """The ticks at which parts stop and work again, (fault, robot) each, for parts that fail; -1: never."""
    parts, first = trace["part"].values.tolist(), trace["stops"].values
    never = np.full((1, *first.shape), -1)
    since, until = trace["outages"].values if "outages" in trace else (first[np.newaxis], never)
    return {part: (since[:, k], until[:, k]) for k, part in enumerate(parts) if (first[k] >= 0).any()}
