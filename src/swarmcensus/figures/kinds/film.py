"""Film of one trial, as an .mp4 or .gif file or as an animation in a notebook."""

from __future__ import annotations

import contextlib
import importlib
import itertools
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import Any, Unpack

import numpy as np
import xarray as xr
from matplotlib.colors import to_rgb
from numpy.typing import NDArray
from PIL import Image

from swarmcensus.figures import one_trial
from swarmcensus.figures.arena_margins import BLACK_TILE, ESTIMATES, LINK, RANGE, WHITE_TILE
from swarmcensus.figures.captions import captioned
from swarmcensus.figures.files import caption_file, checked_dpi, write_caption
from swarmcensus.figures.kinds.arena import Arena
from swarmcensus.figures.page import PageOptions, on_page
from swarmcensus.results import Brains
from swarmcensus.support.errors import InputError
from swarmcensus.support.files import atomic_write, check_writable
from swarmcensus.support.options import wrong_option

MP4_DPI, GIF_DPI = 128, 80
USUAL_WIDTH = 7.0  # inches
LENGTH = 600  # the default number of ticks of a film
QUALITY = "26"  # x264's constant rate factor: lower is better and larger
MOST_GIF_FRAMES = 1000  # Pillow keeps all of them in memory until the last
MOST_GIF_FPS = 50  # viewers slow down faster films

Frame = NDArray[np.uint8]  # (row, column, RGBA); overwritten by the next frame


@on_page
def film(
    results: xr.Dataset,
    *,
    out: str | Path = "film.mp4",
    setting: int | None = None,
    trial: int = 0,
    brain_file: Brains = (),
    first: int | str = 1,
    last: int | str | None = None,
    every: int = 2,
    fps: int = 20,
    dpi: int | None = None,
    robot: int = 0,
    title: str | None = None,
    progress: Callable[[int, int], None] | None = None,
    **more: Unpack[PageOptions],
) -> int:
    """Draw a film of one trial: each frame is the arena at the end of a tick, or a fixed network after a round.

    It is written to a file, whole or not at all, which replaces an older one; the number of frames is returned. A draft
    of its caption goes to the file's name and .caption.txt, as `save` writes it for pictures.

    - `out`: the file. An .mp4 is H.264, 900 pixels wide, and needs imageio-ffmpeg. A .gif is 560 pixels wide, with few
      colours and at most 1,000 frames.
    - `setting`, `trial`, `brain_file`, `robot`, `title`: as in `arena`.
    - `first`, `last`: the first and the last tick, or times such as "5 min"; by default 600 ticks from the first one.
    - `every`: the number of ticks from one frame to the next.
    - `dpi`: dots per inch, by default 128 for an .mp4 and 80 for a .gif, and more if it is narrow.
    - `fps`: frames per second. A GIF rounds the time of a frame to hundredths of a second.
    - `progress`: a function called after each frame with the numbers of finished and of all frames.
    - `width`, `height`, `font_size`, `labels`: the page, and names of brains (see `PageOptions`).

    Raises InputError as `arena` does, for impossible ticks or speeds, another suffix, a missing imageio-ffmpeg, and a
    file that cannot be written. It is raised before the trial is replayed.
    """
    path = Path(out)
    suffix = path.suffix.lower()
    if suffix not in (".mp4", ".gif"):
        raise InputError.of(out, "films are written as .mp4 or .gif")
    clock = one_trial.clock_of(results, setting, trial, brain_file, robot)
    begin = clock.tick(first, "first")
    end = min(begin + LENGTH - 1, clock.last) if last is None else clock.tick(last, "last")
    ticks = _ticks(begin, end, every, fps, gif=suffix == ".gif")
    for file in (path, caption_file(path)):
        check_writable(file)
    ffmpeg = _ffmpeg_for(path) if suffix == ".mp4" else None
    dots = (MP4_DPI if ffmpeg else GIF_DPI) if dpi is None else int(checked_dpi(dpi))
    trace = one_trial.drawn_of(results, setting, trial, brain_file)
    arena = Arena(trace, robot=robot, title=title)
    if dpi is None:  # narrow films have as many dots as wide ones
        dots = round(dots * max(1.0, USUAL_WIDTH / arena.figure.get_figwidth()))
    if ffmpeg:  # at most one dot smaller on each side, so that both sides have an even number of dots
        even = [2 * int(dots * side / 2 + 1e-6) / dots for side in arena.figure.get_size_inches()]
        arena.figure.set_size_inches(*even)
    frames = _drawn(arena, ticks, dots, progress)
    with atomic_write(path) as temporary, contextlib.closing(frames):
        if ffmpeg:
            _write_mp4(ffmpeg, temporary, frames, len(ticks), fps)
        else:
            _write_gif(temporary, frames, fps)
    which = f"{arena.unit.capitalize()}s {ticks[0]:,} to {ticks[-1]:,}, one in {every:,}"
    shown = f"{which}, at {fps} frames a second. The last frame:"
    captioned([arena.axes], film, more=[shown, *arena.sentences()])
    write_caption(arena.figure, path)
    return len(ticks)


def _ticks(first: int, last: int, every: int, fps: int, *, gif: bool) -> range:
    """The ticks that a film shows of a trial. Raises InputError for impossible ticks or speeds."""
    fastest = MOST_GIF_FPS if gif else 240
    if every < 1:
        raise wrong_option("every", every, "should be 1 tick or more")
    if not 1 <= fps <= fastest:
        raise wrong_option("fps", fps, f"should be 1 to {fastest} frames a second")
    ticks = range(first, last + 1, every)
    if not ticks:
        raise InputError(f"no tick from {first} to {last}: a film needs one at least", key="last", value=last)
    if gif and len(ticks) > MOST_GIF_FRAMES:
        fewer = "show a shorter stretch, fewer of its ticks, or write an .mp4"
        raise InputError(f"{len(ticks):,} frames: a GIF may have {MOST_GIF_FRAMES:,}; {fewer}", key="last", value=last)
    return ticks


def _ffmpeg_for(path: Path) -> Any:
    """Return the ffmpeg module for an .mp4. Raises InputError if imageio-ffmpeg is missing."""
    try:
        ffmpeg = importlib.import_module("imageio_ffmpeg")
        ffmpeg.get_ffmpeg_exe()
    except (ImportError, RuntimeError):
        needs = "an .mp4 needs imageio-ffmpeg: pip install 'imageio-ffmpeg>=0.5', or write a .gif"
        raise InputError.of(path, needs) from None
    return ffmpeg


def _drawn(
    arena: Arena, ticks: range, dpi: int, progress: Callable[[int, int], None] | None
) -> Generator[Frame, None, None]:
    """Draw the ticks one by one; the still parts are drawn once and then copied."""
    canvas: Any = arena.figure.canvas  # an Agg canvas: some of its functions have no types
    arena.figure.set_dpi(dpi)
    for artist in arena.moving:
        artist.set_animated(True)  # `canvas.draw` leaves them out
    still, renderer = None, canvas.get_renderer()
    for done, tick in enumerate(ticks, start=1):
        changed = arena.paint(tick)
        arena.show(tick)
        if changed or still is None:
            canvas.draw()
            still = canvas.copy_from_bbox(arena.figure.bbox)
        canvas.restore_region(still)
        for artist in arena.moving:
            artist.draw(renderer)
        yield np.asarray(canvas.buffer_rgba())
        if progress:
            progress(done, len(ticks))


def _write_mp4(ffmpeg: Any, temporary: Path, frames: Iterator[Frame], count: int, fps: int) -> None:
    first = next(frames)
    writer = ffmpeg.write_frames(
        str(temporary), first.shape[1::-1], fps=fps, codec="libx264", quality=None, macro_block_size=2,
        pix_fmt_in="rgba", pix_fmt_out="yuv420p", ffmpeg_log_level="fatal",
        output_params=["-preset", "veryfast", "-crf", QUALITY, "-movflags", "+faststart"],
    )  # fmt: skip
    with contextlib.closing(writer):
        writer.send(None)
        for frame in itertools.chain([first], frames):
            try:
                writer.send(frame)
            except OSError:
                raise OSError("ffmpeg stopped") from None
    # The writer does not report whether its last frames were written, for instance to a full disk.
    try:
        written, _ = ffmpeg.count_frames_and_secs(temporary)
    except RuntimeError:
        written = 0
    if written != count:
        raise OSError("ffmpeg failed")


def _write_gif(temporary: Path, frames: Iterator[Frame], fps: int) -> None:
    # The colours are fixed, as colours computed from a frame would leave out those of small robots.
    greys = np.array([*np.linspace(0.0, 1.0, 18), BLACK_TILE, WHITE_TILE])
    robots = ESTIMATES(np.linspace(0.0, 1.0, 48))[:, :3]
    lines = np.array([to_rgb(LINK), to_rgb(RANGE)])
    soft = [share * lines + (1.0 - share) * (BLACK_TILE + WHITE_TILE) / 2.0 for share in (1.0, 0.7, 0.4)]
    colours = np.concatenate([np.repeat(greys[:, np.newaxis], 3, axis=1), robots, *soft])
    palette = Image.new("P", (1, 1))
    palette.putpalette((255.0 * colours).round().astype(np.uint8).tobytes())
    reduced = (Image.fromarray(f[..., :3]).quantize(palette=palette, dither=Image.Dither.NONE) for f in frames)
    # `optimize` leaves out pixels that do not change, which makes the file ten times smaller
    with temporary.open("wb") as file:
        next(reduced).save(
            file, format="GIF", save_all=True, append_images=reduced, duration=10 * round(100 / fps), loop=0,
            optimize=True,
        )  # fmt: skip
