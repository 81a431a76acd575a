"""Pictures of robots that move show the floor they saw, and the robots and links that the trace holds."""

import functools
import re
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex, to_rgb
from PIL import Image

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.figures.arena_margins import LINK, OFF
from swarmcensus.figures.files import save
from swarmcensus.figures.kinds.arena import Arena, arena as drawn
from swarmcensus.figures.kinds.film import film
from swarmcensus.figures.one_trial import FLOOR, scene_of
from swarmcensus.simulation import sampling
from swarmcensus.summaries.recordings import write_trace
from swarmcensus.support.errors import InputError
from tests.support.drawing import assert_fits, texts
from tests.support.places import ROOT
from tests.support.small import study_of

STUDY = """
name = "pictures for $2 or $3"
seed = 11
trials = 2
swarm = {robots = [1, 9], accuracy = 0.7}
world = {topology = ["ring", "moving"], density = 5, fill_ratio = [0.3, 0.95]}
schedule = {rounds = 40, ticks = 40}
"""
BODY = ", body = {tile = 0.03, sensor = [0.02, -0.01], tick = 0.2, radio_range = 0.5}"  # nothing as usual


@pytest.fixture(scope="module")
def results():
    return sc.run(sc.Study.parse(STUDY), jobs=1)


@pytest.fixture(scope="module")
def file(results, tmp_path_factory):
    path = tmp_path_factory.mktemp("pictures") / "m.nc"
    sc.save(results, path)
    return path


def moving(results, robots, f=0.3):
    is_it = (results.topology == "moving") & (results.robots == robots) & (results.fill_ratio == f)
    return int(results.setting[is_it.values].values[0])


@pytest.fixture(scope="module")
def trace(results):
    return scene_of(results, moving(results, 9), 1)


# ---- floors
@pytest.mark.parametrize("body", ["", BODY])
def test_floors_have_the_colours_that_robots_saw(body):
    study = sc.Study.parse(STUDY.replace("0.95]", f"0.95]{body}"))
    results = sc.run(study, jobs=1)
    for number, setting in enumerate(study.settings()):
        if setting.body is None:
            continue
        trace = sc.replay(results, number, 1)
        floor = sampling.ground(setting, study.seed, 1).all_tiles()
        x, y = trace.position.values[1:].transpose(2, 0, 1)
        c, s = np.cos(trace.heading.values[1:]), np.sin(trace.heading.values[1:])
        ahead, left = setting.body.sensor
        column = np.floor((x + ahead * c - left * s) / setting.body.tile).astype(int) + floor.shape[1] // 2
        row = np.floor((y + ahead * s + left * c) / setting.body.tile).astype(int) + floor.shape[0] // 2
        assert (floor[row, column] == trace.tile.values[1:]).all()
        across = floor.shape[0] * setting.body.tile
        assert floor.shape[0] == floor.shape[1]
        assert trace.attrs["side"] <= across < trace.attrs["side"] + 2 * setting.body.tile


# ---- snapshots
@pytest.fixture(scope="module")
def arena(trace):
    return Arena(trace, robot=3)


@pytest.mark.parametrize("tick", [0, 17])
def test_discs_headings_and_links_are_where_the_trace_says(trace, arena, tick):
    arena.show(tick)
    now = trace.sel(round=tick)
    np.testing.assert_array_equal(arena.discs.get_offsets(), now.position)
    ends = np.array([s[1] - p for s, p in zip(arena.headings.get_segments(), now.position.values, strict=True)])
    np.testing.assert_allclose(np.hypot(*ends.T), trace.attrs["radius"])
    np.testing.assert_allclose(np.arctan2(ends[:, 1], ends[:, 0]), now.heading)
    pairs = trace.link.values[trace.link.values[:, 0] == tick, 1:]
    assert (len(pairs), len(pairs) > 0) == (now.neighbours.sum() / 2, tick > 0)
    drawn = np.array(arena.links.get_segments()).reshape(-1, 2, 2)
    np.testing.assert_array_equal(drawn, now.position.values[pairs])
    reach = tuple(arena.range.center), arena.range.radius
    assert reach == (tuple(now.position.values[3]), trace.attrs["radio_range"])
    right = int(((now.estimate >= 0.3) & (now.estimate < 0.4)).sum())
    assert arena.when.get_text() == f"tick {tick}, {tick / 10:.1f} s"
    assert arena.right.get_text() == f"{right} of 9"


def test_what_is_drawn_is_to_scale_and_in_its_place(trace):
    """By the dots of the picture: the disc's size and colour, a link's colour, tiles, and where they are."""
    arena = Arena(trace)
    arena.show(30)
    arena.links.set_linewidth(3)
    arena.figure.set_dpi(200)
    arena.figure.canvas.draw()
    dots = np.asarray(arena.figure.canvas.buffer_rgba())[..., :3] / 255.0

    def dot(xy):
        column, up = arena.axes.transData.transform(xy)
        return dots[len(dots) - 1 - int(up), int(column)]

    now = trace.sel(round=30)
    radius, tile, half = trace.attrs["radius"], trace.attrs["tile_side"], trace.attrs["side"] / 2
    for i, (xy, heading) in enumerate(zip(now.position.values, now.heading.values, strict=True)):
        colour = arena.colours.to_rgba(float(now.estimate[i]))[:3]
        for turn in (0.5, 0.75, 1.0, 1.25, 1.5):  # of half a turn, away from the heading
            away = np.array([np.cos(heading + turn * np.pi), np.sin(heading + turn * np.pi)])
            np.testing.assert_allclose(dot(xy + 0.85 * radius * away), colour, atol=0.02)
    x = now.position.values
    middles = [(x[i] + x[j]) / 2 for _, i, j in trace.link.values[trace.link.values[:, 0] == 30]]
    seen = [middle for middle in middles if np.hypot(*(x - middle).T).min() > 1.1 * radius]
    assert seen
    np.testing.assert_allclose([dot(middle) for middle in seen], np.tile(to_rgb(LINK), (len(seen), 1)), atol=0.1)
    floor = trace[FLOOR].values
    centres = (np.stack(np.indices(floor.shape)[::-1], -1) - floor.shape[0] / 2 + 0.5) * tile
    inside = np.abs(centres).max(axis=-1) < half - tile
    shades = np.array([np.mean(dot(place)) for place in centres[inside][::7]])
    black = floor[inside][::7] > 0
    dark, light = np.median(shades[black]), np.median(shades[~black])
    assert dark < 0.2 < 0.85 < light  # black tiles are black
    assert np.mean((shades < (dark + light) / 2) == black) > 0.85  # but where robots hide it


def test_estimates_have_the_colours_of_the_live_page():
    page = (ROOT / "src/swarmcensus/live/page/colours.js").read_text(encoding="utf-8")
    stops = re.findall(r"\[(\d+), (\d+), (\d+)\]", re.search(r"const OFF = (.*);", page)[1])
    assert [to_hex([int(part) / 255 for part in stop]) for stop in stops] == list(OFF)


def test_a_lone_robot_a_robot_without_estimate_and_no_floor(results, trace, tmp_path: Path):
    assert " of 1\n" in texts(drawn(scene_of(results, moving(results, 1)), tick=40))
    trace = trace.drop_vars(FLOOR).isel(round=slice(10, 30)).transpose("robot", "axis", ...).copy(deep=True)
    trace["estimate"][2, 10] = np.nan
    figure = drawn(trace, tick=20, title="$mine of $2")
    assert "black tile" not in texts(figure)
    assert "$mine of $2" in texts(figure)
    path, _ = save(figure, tmp_path / "x", ["svg"])
    assert path.stat().st_size < 200_000


def test_opinions_are_black_and_white(trace):
    voters = trace.assign(estimate=(trace["estimate"] > 0.3).astype(float), honest=("robot", [1] * 7 + [0] * 2))
    arena = Arena(voters.assign_attrs(opinions=1))
    arena.show(30)
    black = voters["estimate"].sel(round=30).values
    np.testing.assert_array_equal(arena.discs.get_facecolor()[:, 0], 1 - black)
    count = int(black[:7].sum())
    assert arena.right.get_text() == f"{count} black, {7 - count} white honest ones"
    assert "right bin" not in texts(arena.figure)
    assert len(arena.crosses.get_segments()) == 4  # two liars
    middles = np.mean(arena.crosses.get_segments(), axis=1)
    np.testing.assert_allclose(middles[::2], trace["position"].sel(round=30).values[7:])
    (place,) = sc.plot.curves(voters.assign_attrs(opinions=1)).axes
    [share] = [line.get_ydata() for line in place.lines if line.get_label() == "mean"]
    np.testing.assert_allclose(share, voters["estimate"][:, :7].mean("robot"))


@pytest.mark.parametrize("width", ["double", "slide"])
def test_a_long_title_is_whole(width, trace):
    title = ", ".join(f"parameter_{k} = {k}" for k in range(14))
    figure = drawn(trace, tick=30, title=title, width=width)
    assert title in texts(figure).replace("\n", " ")
    assert_fits(figure)
    assert figure.get_figheight() <= 7.5


def test_what_cannot_be_drawn_is_an_input_error(results, trace):
    for what, said in (
        (trace.isel(row=slice(10)), "does not cover"), (trace.drop_vars("link"), "links=True"),
        (sc.replay(results, 0, 0), "a fixed network from results"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=said):
            drawn(what, tick=1)


@pytest.mark.interpreted
def test_a_network_is_drawn_as_on_the_live_page(results, tmp_path: Path):
    number = int(results.setting[((results.topology == "ring") & (results.robots == 9)).values].values[0])
    scene = scene_of(results, number, 1)
    arena = Arena(scene)
    arena.show(30)
    places = arena.discs.get_offsets()
    np.testing.assert_allclose(places[0], [0.0, 0.46], atol=1e-12)  # the first of a ring stands at the top
    pairs = {tuple(sorted(pair)) for pair in scene.link.values[:, 1:].tolist()}
    assert pairs == {tuple(sorted((i, (i + 1) % 9))) for i in range(9)}
    np.testing.assert_allclose(np.array(arena.links.get_segments()), places[scene.link.values[:, 1:]])
    assert arena.when.get_text() == "round 30"
    assert "heading" not in texts(arena.figure)
    assert film(results, out=tmp_path / "x.gif", setting=number, last=6) == 3
    assert "Rounds 1 to 5, one in 2" in (tmp_path / "x.gif.caption.txt").read_text()


# ---- robots that fail
WRITTEN = ("png", "svg", "caption.txt")
FAULTS = 'faults = [{at = 10, robots = 3, stop = "moving"}, {at = 20, robots = 4, stop = ["sensing", "talking"]}]'


@functools.cache
def faulty_scene(faults):
    text = STUDY.replace("[1, 9]", "9").replace('["ring", "moving"]', '"moving"').replace("rounds = 40, ", "")
    found = sc.Study.parse(faults + text)
    return found, scene_of(sc.run(found, jobs=1), 0, 1)


def test_a_trace_says_when_parts_of_robots_stop(tmp_path: Path):
    study, trace = faulty_scene(FAULTS)
    first = sampling.stops(study.settings()[0], study.seed, 1)
    assert trace["stops"].dims == ("part", "robot")
    for part, row in (("moving", 0), ("sensing", 1), ("talking", 2)):
        told = trace["stops"].sel(part=part).values
        np.testing.assert_array_equal(told, np.where(first[row] < 1000, first[row], -1))
        assert (told >= 0).sum() == (3 if part == "moving" else 4)
    write_trace(trace.drop_vars("link"), tmp_path / "t.csv")
    names = (tmp_path / "t.csv").read_text().splitlines()[0].split(",")
    assert "stops" not in names
    assert {"x", "position_x", "position_y"} <= set(names)  # the brain has a field x of its own
    table = np.genfromtxt(tmp_path / "t.csv", delimiter=",", names=True)
    np.testing.assert_array_equal(table["x"], trace["x"].values.ravel())
    np.testing.assert_array_equal(table["position_x"], trace["position"].sel(axis="x").values.ravel())
    write_trace(trace, tmp_path / "t.nc")
    with xr.open_dataset(tmp_path / "t.nc", engine="h5netcdf") as kept:
        np.testing.assert_array_equal(kept["stops"], trace["stops"])


@pytest.fixture(scope="module")
def faulty_arena():
    return Arena(faulty_scene(FAULTS)[1])


@pytest.mark.parametrize("tick", [9, 10, 20])
def test_failed_parts_are_marked(faulty_arena, tick):
    arena, trace = faulty_arena, faulty_scene(FAULTS)[1]
    arena.show(tick)
    place, radius = trace["position"].sel(round=tick).values, trace.attrs["radius"]
    expected = set()
    for part, degrees in (("moving", 0), ("sensing", 45), ("talking", 135)):
        at = trace["stops"].sel(part=part).values
        expected |= {(i, (degrees + turn) % 360) for i in np.flatnonzero((at > 0) & (at <= tick)) for turn in (0, 180)}
    found = set()
    for line in arena.failed.get_segments():
        middle = line.mean(axis=0)
        robot = int(np.argmin([abs(np.hypot(*(middle - xy)) - 1.2 * radius) for xy in place]))
        x, y = middle - place[robot]
        found.add((robot, round(np.degrees(np.arctan2(y, x))) % 360))
        assert np.hypot(*(line[0] - place[robot])) == pytest.approx(0.7 * radius)
    assert found == expected
    assert len(found) == 6 * (tick >= 10) + 16 * (tick >= 20)


def test_the_key_names_the_parts_that_fail_and_no_others(trace, tmp_path: Path):
    said = texts(drawn(trace, tick=30))
    assert "stopped" not in said
    assert "stops" not in trace
    said = texts(drawn(faulty_scene(FAULTS)[1], tick=1))
    assert all(f"stopped {part}" in said for part in ("moving", "sensing", "talking"))
    _, trace = faulty_scene('faults = [{at = 30, robots = 0.5, stop = "talking", until = 35}]')
    said = texts(drawn(trace, tick=1))
    assert "stopped talking" in said
    assert "stopped moving" not in said
    arena = Arena(trace)
    arena.show(35)
    assert not arena.failed.get_segments()  # they work again


# ---- films
def test_a_film_has_its_frames_and_they_are_snapshots(trace, tmp_path: Path):
    path, told = tmp_path / "x.gif", []
    assert film(trace, out=path, first=3, last=12, every=4, fps=10, progress=lambda *n: told.append(n)) == 3
    assert told == [(1, 3), (2, 3), (3, 3)]
    assert {each.name for each in tmp_path.iterdir()} == {"x.gif", "x.gif.caption.txt"}
    said = (tmp_path / "x.gif.caption.txt").read_text().replace("\n", " ")
    assert "film of one trial: each frame is the arena at the end of a tick" in said
    assert "Ticks 3 to 11, one in 4, at 10 frames a second. The last frame:" in said
    assert "robots at tick 11" in said
    with Image.open(path) as gif:
        assert gif.n_frames == 3
        for k, tick in enumerate((3, 7, 11)):
            gif.seek(k)
            assert gif.info["duration"] == 100
            frame = np.asarray(gif.convert("RGB"))
            figure = drawn(trace, tick=tick)
            figure.set_dpi(80)
            figure.canvas.draw()
            off = np.abs(np.asarray(figure.canvas.buffer_rgba())[..., :3].astype(int) - frame)
            assert off.mean() < 3  # of 255: fewer colours, and the film's speed in words
            assert np.mean(off.max(axis=2) > 60) < 0.005
    if ffmpeg := pytest.importorskip("imageio_ffmpeg"):
        film(trace, out=tmp_path / "x.mp4", first=3, last=12, every=4, fps=10)
        assert ffmpeg.count_frames_and_secs(tmp_path / "x.mp4") == (3, pytest.approx(0.3, abs=0.01))


def test_a_film_is_whole_or_not_at_all(trace, tmp_path: Path):
    pytest.importorskip("imageio_ffmpeg")

    def stop(done, _):
        if done == 2:
            raise KeyboardInterrupt

    (tmp_path / "y.gif.caption.txt").mkdir()
    with pytest.raises(InputError, match=r"y\.gif\.caption\.txt"):
        film(trace, out=tmp_path / "y.gif", last=4)
    (tmp_path / "y.gif.caption.txt").rmdir()
    for path in (tmp_path / "x.gif", tmp_path / "x.mp4"):
        path.write_text("old")
        with pytest.raises(KeyboardInterrupt):
            film(trace, out=path, last=4, progress=stop)
        assert path.read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 2


def test_a_film_that_ffmpeg_did_not_finish_is_an_error(trace, tmp_path: Path, monkeypatch):
    ffmpeg = pytest.importorskip("imageio_ffmpeg")

    def killed(*_, **__):
        yield
        raise OSError("Broken pipe\n\nFFMPEG COMMAND: ...")

    monkeypatch.setattr(ffmpeg, "write_frames", killed)
    with pytest.raises(InputError, match=r"^cannot write .*x\.mp4: ffmpeg (failed|stopped)$"):
        film(trace, out=tmp_path / "x.mp4", last=4)
    assert not list(tmp_path.iterdir())


def test_films_that_cannot_be_are_input_errors(trace, tmp_path: Path, monkeypatch):
    with pytest.raises(InputError, match="every=0"):
        film(trace, out=tmp_path / "x.gif", every=0)
    monkeypatch.setattr("swarmcensus.figures.kinds.film.MOST_GIF_FRAMES", 10)
    with pytest.raises(InputError, match=r"11 frames: a GIF may have 10.*write an \.mp4"):
        film(trace, out=tmp_path / "x.gif", first=0, last=10, every=1)
    assert not list(tmp_path.iterdir())


# ---- the command line
@pytest.mark.long
def test_arena_and_film_from_the_command_line(file, here, accepted):
    drawn = accepted("plot", file, "--kind", "arena", "--tick", "12", "--robot", "0").out
    assert drawn.split() == [str(file.with_name(f"m-arena.{ending}")) for ending in WRITTEN]
    assert main(["plot", str(file), "--kind", "arena", "--where", "robots == 9", "--out", "x.pdf"]) == 0
    film_it = ["plot", str(file), "--kind", "film", "--first", "1", "--last", "6", "--every", "2"]
    said = accepted(*film_it, "--out", "x.gif", "--fps", "5")
    assert "x.gif: 3 frames" in said.out
    assert said.err == ""
    with Image.open("x.gif") as gif:
        assert (gif.n_frames, gif.info["duration"]) == (3, 200)
    pytest.importorskip("imageio_ffmpeg")
    assert main([*film_it, "--trial", "1"]) == 0
    assert file.with_name("m-film.mp4").stat().st_size > 10_000
    assert {p.name for p in here.iterdir()} == {*("x.gif", "x.gif.caption.txt", "x.pdf", "x.pdf.caption.txt")}


@pytest.mark.parametrize(("options", "said"), [
    ("arena --setting 99", "--setting 99: these results hold setting"),
    ("arena --tick 41", "tick 41: this trial has ticks 0 to 40"),
    ("arena --first 3", "--kind arena has no key first: it has "),
    ("film --first 9 --last 5 --out x.gif", "no tick from 9 to 5"),
    ("film --out file/x.gif", "cannot write file/x.gif"),
    ("film --brain-file none.py", "there is no such file"),
    ("film --robot 9", "--robot 9: the robots are numbered 0 to "),
    ("film --fps 500", "should be 1 to 240 frames a second"),
    ("film", "pip install 'imageio-ffmpeg"),
])  # fmt: skip
def test_wrong_trials_and_options_are_refused(options, said, file, here, refused, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    (here / "file").touch()
    assert said in refused("plot", file, "--kind", *options.split())


@pytest.mark.long
def test_a_trace_says_what_opinions_are():
    trace = sc.replay(sc.run(study_of("voter", 2, rounds=40, trials=1), jobs=1), 0, 0)
    assert trace.attrs["opinions"] == 1
    assert "explore" not in trace.attrs["title"]  # nobody gave it
