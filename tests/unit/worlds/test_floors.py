"""Floors: how much of them is black and where, what is kept of them, and that independent tiles stay as they were."""

import math
import re
import struct
import zlib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from PIL import Image
from scipy import stats

import swarmcensus as sc
from swarmcensus.engine.addresses import address
from swarmcensus.engine.random import block, counter, unit
from swarmcensus.simulation import sampling
from swarmcensus.studies import addresses
from swarmcensus.worlds import ground, patterns
from swarmcensus.worlds.chance import Chance
from swarmcensus.worlds.floors import benchmark, clusters
from swarmcensus.worlds.patterns import parse_floors
from swarmcensus.worlds.pictures import MOST_PIXELS, read_image
from tests.support.small import moving_of

FILLS = (0.0, 0.05, 0.55, 0.95, 1.0)
SIGMAS = 5.0  # a true statement fails once in 1.7 million draws


@pytest.fixture(scope="module")
def gradient(tmp_path_factory):
    """A picture that gets lighter from left to right, in few grey levels; its uppermost tenth is black."""
    path = tmp_path_factory.mktemp("images") / "gradient.png"
    grey = np.tile(np.repeat(np.arange(30, 230, 20, np.uint8), 8), (40, 1))
    grey[:4] = 0
    Image.fromarray(grey).save(path)
    return path


def setting_of(floor, fill_ratio=0.55, robots=25, density=10.0, **body):
    body = {"tile": 0.01} | body
    return moving_of(robots, density=density, fill_ratio=fill_ratio, floor=floor, body=body)


def every_kind(gradient):
    images = [{"image": str(gradient), "mode": mode} for mode in ("threshold", "dither")]
    return ["tiles", {"clusters": 0.2}, {"stripes": 0.3}, "half", *images]


def within_reach(setting):
    """Which tiles of the floor a ground sensor can stand over, by the distance of each one's centre."""
    half, body = setting.arena_side / 2, setting.body
    across = 2 * math.ceil(half / body.tile)
    centre = (np.arange(across) - across // 2 + 0.5) * body.tile
    (x, y), inner = np.meshgrid(centre, centre), half - body.radius
    away = np.hypot(x - np.clip(x, -inner, inner), y - np.clip(y, -inner, inner))
    return (away <= math.hypot(*body.sensor)) & (np.abs(x) <= half) & (np.abs(y) <= half)


# ---- how much is black
@pytest.mark.parametrize("fill_ratio", FILLS)
def test_as_much_is_black_as_was_asked_for(gradient, fill_ratio):
    """To one tile where a quantile decides, else within chance and what is cut off of the last stripe."""
    for floor in every_kind(gradient):
        setting = setting_of(floor, fill_ratio)
        tiles = within_reach(setting).sum()
        chance = SIGMAS * math.sqrt(fill_ratio * (1 - fill_ratio) / tiles)
        allowed = 0.5 / tiles + 1e-12
        if setting.floor.kind == "tiles":
            allowed = chance
        elif setting.floor.kind == "stripes":
            width = setting.arena_side - 2 * setting.body.radius
            allowed = chance + fill_ratio * (1 - fill_ratio) * dict(setting.floor.keys)["length"] / width
        for trial in range(3):
            assert abs(sampling.ground(setting, 1, trial).true_fill_ratio - fill_ratio) <= allowed, floor


@pytest.mark.parametrize("body", [{}, {"sensor": (0.2, -0.1), "tile": 0.03}, {"sensor": (0.0, 0.0)}])
def test_the_true_fill_ratio_is_that_of_the_tiles_in_reach(body):
    """Also with a sensor that reaches beyond the body, and so up to the walls."""
    for floor in ("tiles", {"clusters": 0.15}, {"stripes": 0.4}, "half"):
        setting = setting_of(floor, 0.35, robots=6, density=5.0, **body)
        found = sampling.ground(setting, 2, 1)
        assert found.true_fill_ratio == found.all_tiles()[within_reach(setting)].mean()


@given(st.lists(st.floats(-10, 10), min_size=1, unique=True), st.floats(0, 1))
def test_a_quantile_has_its_share_below(scores, share):
    scores = np.array(scores)
    assert (scores < ground.quantiles(scores, np.array([share]))).sum() == round(share * len(scores))


# ---- independent tiles
def test_colours_of_independent_tiles():
    """By the formula: the address says nothing of the kind of floor, and a tile's word is held against f."""
    for floor in (None, "tiles"):
        world = {"topology": "moving", "density": 3, "fill_ratio": 0.55} | ({"floor": floor} if floor else {})
        setting = sc.Study(trials=1, swarm={"robots": 2, "accuracy": 0.7}, world=world).settings()[0]
        key = address(7, "floor", robots=2, density=3.0, tile=0.01, fill_ratio=0.55)
        black = sampling.ground(setting, 7, 4).all_tiles()
        zero = (1 << 30) - len(black) // 2
        for row, column in np.argwhere(black < 2)[::7]:
            place = np.uint64(counter(zero + column, zero + row))
            word, _ = block(key[0], key[1], np.uint64(counter(4, 0)), place)
            assert black[row, column] == (unit(np.uint64(word)) < 0.55)
    assert (sampling.ground(replace(setting, floor=None), 7, 4).all_tiles() == black).all()


# ---- clusters
@pytest.mark.parametrize("length", [0.02, 0.03, 0.05, 0.2, 0.21, 0.333, 1.5])
def test_the_kernel_has_the_correlation_that_is_asked_for(length):
    """exp(-(d / length)^2), from every place between two nodes and at every distance, but for the kernel's cut-off."""
    weights = clusters.kernel(length, 0.01)
    apart, taps = weights.shape
    np.testing.assert_allclose((weights**2).sum(axis=1), 1.0, rtol=1e-12)
    reach = math.ceil(2.5 * length / 0.01)
    nodes = np.zeros((apart + reach + 1, (apart + reach) // apart + taps + 1))
    for tile in range(len(nodes)):
        nodes[tile, tile // apart : tile // apart + taps] = weights[tile % apart]
    for start in range(apart):
        distance = 0.01 * np.arange(reach + 1)
        correlation = nodes[start : start + reach + 1] @ nodes[start]
        np.testing.assert_allclose(correlation, np.exp(-((distance / length) ** 2)), atol=0.001)


def field_of(setting, seed, trial):
    half = math.ceil(setting.arena_side / 2 / setting.body.tile)
    place = np.arange(-half, half, dtype=np.int32)
    return sampling.ground(setting, seed, trial).number(np.stack(np.meshgrid(place, place), axis=-1))


def test_nodes_that_are_not_kept_are_the_same_numbers(monkeypatch):
    setting = setting_of({"clusters": 0.07}, robots=1, density=1.0)
    kept = field_of(setting, 1, 2)
    monkeypatch.setattr(clusters, "MOST_NODES", 0)
    assert (field_of(setting, 1, 2) == kept).all()
    monkeypatch.undo()
    far = np.array([[[-4000, 70_000], [3, 4]]], np.int32)  # beyond the walls
    assert np.isfinite(sampling.ground(setting, 1, 2).number(far)).all()


# ---- stripes and halves
@pytest.mark.parametrize(("period", "share"), [(0.3, 0.55), (0.125, 0.3), (0.5, 0.95)])
def test_stripes_have_period_width_axis_and_phase(period, share):
    setting = setting_of({"stripes": period}, share)
    axes, phases = [], []
    for trial in range(40):
        black = sampling.ground(setting, 1, trial).all_tiles().astype(float)
        axes.append(int(black.mean(axis=0).std() < black.mean(axis=1).std()))  # 0: stripes run along y
        line = black.mean(axis=axes[-1])  # a tile that a stripe ends in is black with the share that is covered
        n = len(line)
        x = (np.arange(n) - n // 2 + 0.5) * 0.01
        wave = np.exp(-2j * np.pi * x / period)
        whole = slice(0, int(int(n * 0.01 / period) * period / 0.01 + 0.5))
        phases.append(np.angle((line[whole] * wave[whole]).mean()) / (2 * np.pi) % 1)
        phase = Chance(addresses.floor_key(setting, 1), trial).uniform(2)[1]
        assert np.abs(line - covered(x, period, share, phase)).max() < SIGMAS * math.sqrt(0.25 / n)
    assert 8 < sum(axes) < 32  # of 40 coins, but once in 20,000
    assert stats.kstest(phases, "uniform").pvalue > 1e-4


def covered(x, period, share, phase):
    fine = x[:, np.newaxis] + (np.arange(50) + 0.5) / 50 * 0.01 - 0.005
    return ((fine / period + phase) % 1.0 < share).mean(axis=1)


def test_half_a_floor_is_black_on_a_side_of_each_trial():
    setting = setting_of("half", 0.3)
    sides = []
    for trial in range(40):
        black = sampling.ground(setting, 1, trial).all_tiles()
        n = len(black)
        ways = [black, black[::-1], black.T, black.T[::-1]]  # seen from each side
        (side,) = (k for k, way in enumerate(ways) if way[: n // 5].all() and not way[n // 2 :].any())
        rows = ways[side].mean(axis=1)
        assert ((rows == 0) | (rows == 1)).sum() >= n - 1  # one line is black in part
        sides.append(side)
    assert np.bincount(sides, minlength=4).min() >= 2  # of 40 throws, but once in 1,000 for a fair four-sided die


# ---- pictures
def test_a_picture_is_black_where_it_is_darkest(gradient):
    black = sampling.ground(setting_of({"image": str(gradient)}, 0.55), 1, 0).all_tiles()
    n = len(black)
    assert black[-n // 11 :].all()  # the top of the picture is where y is largest
    below = black[: -n // 9]
    assert below[:, : int(0.49 * n)].all()
    assert not below[:, int(0.61 * n) :].any()
    tie = below[:, int(0.51 * n) : int(0.59 * n)]  # one grey level: ties are broken tile by tile
    assert 0 < tie.mean() < 1
    assert abs(np.corrcoef(tie[:, 1:].ravel(), tie[:, :-1].ravel())[0, 1]) < 5 / math.sqrt(tie.size)


def test_a_dithered_picture_is_the_blacker_the_darker_it_is(gradient):
    """Odds of black differ from odds of darkness by one factor, within 5 standard errors in each grey level."""
    setting = setting_of({"image": str(gradient), "mode": "dither"}, 0.55)
    floors = np.array([sampling.ground(setting, 1, trial).all_tiles() for trial in range(4)])
    n = floors.shape[1]
    bands = [floors[:, : -n // 9, int((k + 0.1) * n / 10) : int((k + 0.9) * n / 10)] for k in range(10)]
    share = np.array([band.mean() for band in bands])
    error = np.array([0.5 / math.sqrt(band.size) for band in bands]) / (share * (1 - share))
    darkness = 1 - np.arange(30, 230, 20) / 255
    odds = np.log(share / (1 - share) * (1 - darkness) / darkness)
    assert (np.diff(share) < 0).all()
    assert (np.abs(odds - odds[4]) < SIGMAS * np.hypot(error, error[4])).all()
    assert (floors[0] != floors[1]).any()


def write(path, array, **options):
    Image.fromarray(array).save(path, **options)
    return path


def bare_png(path, bits, kind, values, *more):
    """A PNG of one line with these samples, and more chunks."""
    head = struct.pack(">2I5B", len(values) // {0: 1, 2: 3, 4: 2}[kind], 1, bits, kind, 0, 0, 0)
    row = int("1" + "".join(f"{value:0{bits}b}" for value in values).ljust(8, "0"), 2)
    row = row.to_bytes((row.bit_length() + 7) // 8)[1:]
    chunks = [("IHDR", head), *more, ("IDAT", zlib.compress(b"\0" + row)), ("IEND", b"")]
    texts = ((name.encode() + data, len(data)) for name, data in chunks)
    parts = (struct.pack(">I", size) + text + struct.pack(">I", zlib.crc32(text)) for text, size in texts)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(parts))
    return path


def test_every_kind_of_png_is_read(tmp_path):
    grey = np.array([[0, 100], [200, 255]], np.uint8)
    expected = grey.astype(int) * 257
    assert (read_image(write(tmp_path / "l.png", grey)) == expected).all()
    assert (read_image(write(tmp_path / "rgb.png", np.repeat(grey[..., np.newaxis], 3, axis=2))) == expected).all()
    clear = np.zeros((2, 2, 4), np.uint8)
    clear[..., 3] = 255 - grey  # black, the more transparent the whiter
    assert (read_image(write(tmp_path / "rgba.png", clear)) == expected).all()
    assert (read_image(write(tmp_path / "la.png", clear[..., 2:])) == expected).all()
    deep = np.array([[0, 12345], [65535, 257]], np.uint16)
    assert (read_image(write(tmp_path / "i16.png", deep)) == deep).all()
    assert (read_image(write(tmp_path / "t16.png", deep, transparency=12345)) == [[0, 65535], [65535, 257]]).all()
    palette = Image.fromarray(np.array([[0, 1]], np.uint8), "P")
    palette.putpalette([255, 0, 0, 0, 0, 255])
    palette.save(tmp_path / "p.png")
    assert (read_image(tmp_path / "p.png") == np.array([[76, 29]]) * 257).all()  # red and blue by their luma
    palette.save(tmp_path / "t.png", transparency=1)
    assert read_image(tmp_path / "t.png").tolist() == [[76 * 257, 65535]]
    for bits, expected in ((1, [0, 65535] * 2), (2, [0, 65535, 2 * 21845, 65535]), (4, [0, 65535, 2 * 4369, 3 * 4369])):
        path = bare_png(tmp_path / f"t{bits}.png", bits, 0, np.array([0, 1, 2, 3]) % 2**bits, ("tRNS", b"\0\1"))
        assert read_image(path).tolist() == [expected]
    Image.fromarray(grey > 150).save(tmp_path / "1.png")
    assert (read_image(tmp_path / "1.png") == [[0, 0], [65535, 65535]]).all()


def test_photographs_are_read_as_viewers_turn_them(tmp_path):
    grey = np.repeat([[40, 200]], 8, axis=1).repeat(8, axis=0).astype(np.uint8)
    turned = Image.Exif()
    turned[0x0112] = 6  # a quarter to the right
    for mode in ("L", "RGB", "CMYK"):
        Image.fromarray(grey).convert(mode).save(tmp_path / "a.jpg", quality=100, exif=turned)
        found = read_image(tmp_path / "a.jpg")
        assert found.shape == (16, 8)
        assert np.abs(found - np.rot90(grey, -1).astype(int) * 257).max() <= 5 * 257


# ---- studies and datasets
STUDY = """
name = "floors"
seed = 11
trials = 2
swarm = {brain = ["minimalistic", "legacy"], robots = 6, accuracy = 0.8}
schedule.ticks = 150
measure = {checkpoints = [50, 150], truth = "floor"}
[world]
topology = "moving"
density = 5
fill_ratio = 0.35
floor = ["tiles", {clusters = 0.2}, {stripes = 0.5}, "half", {image = "gradient.png"}, {image = "gradient.png", mode = "dither"}]
body.message_delay = 0
"""  # noqa: E501


@pytest.mark.long
def test_an_image_is_needed_once(tmp_path, gradient):
    file = tmp_path / "pic.png"
    file.write_bytes(gradient.read_bytes())
    study = sc.Study.parse(STUDY.replace("gradient.png", "pic.png"), context={"base": tmp_path})
    sc.save(sc.run(study), tmp_path / "s.nc")
    file.unlink()
    loaded = sc.load(tmp_path / "s.nc")
    assert loaded["floor_pic"].dtype == np.uint16
    for k in (4, 5):
        trace = sc.replay(tmp_path / "s.nc", k, 1)
        assert (trace["estimate"].values[-1] == loaded["final_estimate"].values[k, 1]).all()
    assert study.with_(trials=1).settings() == study.settings()
    elsewhere = sc.Study.parse(STUDY, context={"base": gradient.parent}).settings()
    for a, b in zip(study.settings(), elsewhere, strict=True):
        assert (addresses.floor_key(a, 1) == addresses.floor_key(b, 1)).all()
    assert len({tuple(addresses.floor_key(s, 1)) for s in elsewhere}) == 6
    write(tmp_path / "gradient.png", np.array([[0, 255]], np.uint8))
    other = sc.Study.parse(STUDY, context={"base": tmp_path}).settings()
    assert not (addresses.floor_key(other[4], 1) == addresses.floor_key(elsewhere[4], 1)).any()


def test_fixed_networks_have_no_floor(small_results):
    assert set(small_results["floor"].values) == {""}
    assert np.isnan(small_results["true_fill_ratio"].values).all()


def test_a_kind_of_floor_is_a_file_of_its_name(gradient):
    assert patterns.PLUGINS.shipped == ("benchmark", "clusters", "half", "image", "stripes", "tiles")
    contents = []
    for floor in every_kind(gradient):
        (read,) = parse_floors(floor, gradient.parent, {})
        contents.append(read.content)
        assert not read.edition
        assert parse_floors(read.form, gradient.parent, {}) == [read]
    digest = contents[-1][2]
    assert contents == [  # what the random numbers of every study depend on: never to be changed
        ["tiles", 0.0, None, ""], ["clusters", 0.2, None, ""], ["stripes", 0.3, None, ""], ["half", 0.0, None, ""],
        ["image", 0.0, digest, "threshold"], ["image", 0.0, digest, "dither"],
    ]  # fmt: skip
    assert type(parse_floors({"clusters": 1}, None, {})[0].content[1]) is float


PLAIN = """
trials = 1
swarm = {robots = 5, accuracy = 0.7}
world = {topology = "moving", density = 2, fill_ratio = 0.5, floor = FLOOR}
"""


@pytest.mark.parametrize(("floor", "said"), [
    ('{benchmark = "stars"}', "did you mean 'star'?"),
    ('{benchmark = "star", cells = 1}', "cells = 1: should be greater than or equal to 2"),
    ('"checks"', 'world.floor = "checks": a floor is one of {benchmark = "star", cells = 20}, {cl'),
    ("{clusters = 0.2, stripes = 1}", "floor clusters has no key stripes: it has length"),
    ("{clusters = 0}", "world.floor = {clusters = 0}"),
    ('"clusters"', "floor clusters needs the key length: write {clusters = 0.2}"),
    ("{half = 2}", 'floor half: it has no keys: write "half"'),
    ("{stripes = nan}", "floor stripes: length = nan: should be a finite number"),
    ('["tiles", "tiles"]', "a value is twice in a list"),
    ('{image = "a.png", moed = "dither"}', "floor image has no key moed: did you mean 'mode'?"),
    ("{image = 3}", "an image is the path of a PNG or JPEG file"),
    ('{image = "none.png"}', "none.png: there is no such file"),
    ('{image = "text.png"}', "text.png: not a PNG or JPEG file"),
    ('{image = "cut.png"}', "cut.png: cannot be read: "),
    ('{image = "deep.png"}', "deep.png: should be one picture, of 8 bits, or of 16 in grey alone"),
    ('{image = "film.png"}', "film.png: should be one picture"),
    ('{image = "huge.png"}', f"huge.png: 4,097 x 4,097 pixels: should be {MOST_PIXELS:,} at the most"),
    ('[{image = "a.png"}, {image = "more/a.png"}]', "two images of world.floor have one name: a"),
])  # fmt: skip
def test_what_is_wrong_is_named(floor, said, tmp_path):
    noisy = np.random.default_rng(1).integers(0, 256, (64, 64)).astype(np.uint8)
    (tmp_path / "more").mkdir()
    write(tmp_path / "more" / "a.png", noisy)
    (tmp_path / "text.png").write_text("no picture")
    (tmp_path / "cut.png").write_bytes(write(tmp_path / "a.png", noisy).read_bytes()[:2000])
    bare_png(tmp_path / "deep.png", 16, 2, [1000, 2000, 3000])
    frames = [Image.fromarray(noisy), Image.fromarray(255 - noisy)]
    frames[0].save(tmp_path / "film.png", save_all=True, append_images=frames[1:])
    if "huge" in floor:
        Image.new("1", (4097, 4097)).save(tmp_path / "huge.png")
    with pytest.raises(sc.InputError, match=re.escape(said)):
        sc.Study.parse(PLAIN.replace("FLOOR", floor), context={"base": tmp_path})


# ---- benchmark patterns
def cells_of(pattern, fill_ratio, trial=0):
    """The 20 x 20 cells of a benchmark floor, by the colour of the middle tile of each."""
    setting = setting_of({"benchmark": pattern}, fill_ratio)
    floor = sampling.ground(setting, 3, trial)
    tiles = floor.all_tiles()
    middle = np.floor((np.arange(20) - 9.5) / 20 * setting.arena_side / 0.01).astype(int) + len(tiles) // 2
    return tiles[np.ix_(middle, middle)].astype(bool), floor.true_fill_ratio


def diagonals(cells):
    """In how many diagonals, of either direction, all cells have one colour; of 39."""
    return max(sum(len(set(np.diagonal(c, k).tolist())) == 1 for k in range(-19, 20)) for c in (cells, cells[::-1]))


@pytest.mark.parametrize("fill_ratio", [0.3, 0.55])
@pytest.mark.parametrize("pattern", benchmark.PATTERNS)
def test_benchmark_pattern_has_its_share_and_shape(pattern, fill_ratio):
    cells, share = cells_of(pattern, fill_ratio)
    assert abs(share - fill_ratio) < 1e-4
    other, _ = cells_of(pattern, fill_ratio, 1)
    images = [np.rot90(cells[::flip], k) for flip in (1, -1) for k in range(4)]
    drawn = pattern in ("random", "star", "band", "bandwidth-r", "band-stripe")
    assert min((other != image).mean() for image in images) > 0.05 if drawn else True
    lines = [cells.all(axis).sum() + (~cells).all(axis).sum() for axis in (0, 1)]  # rows and columns of one colour
    assert (max(lines) >= 18) == (pattern in ("stripe", "band-stripe"))
    assert (diagonals(cells) >= 36) == (pattern in ("band", "bandwidth"))
    corners, middle = cells[[0, 0, -1, -1], [0, -1, 0, -1]].sum(), cells[9:11, 9:11].sum()
    if pattern == "block":
        assert (corners, middle) == (0, 4)
    if pattern == "off-diagonal":
        assert (corners, middle) == (2, 2 if fill_ratio > 0.5 else 0)
    if pattern in ("bandwidth", "bandwidth-r"):
        i, j = np.indices(cells.shape)
        away = [np.abs(i - j), np.abs(i + j - 19)]  # from each diagonal
        assert min(d[cells].mean() - d[~cells].mean() for d in away) < -3
    if pattern == "star":
        rows, columns = cells.all(1), cells.all(0)
        assert (cells != (rows[:, np.newaxis] | columns)).mean() < 0.05
        assert (rows.any(), columns.any()) == (True, True)


def test_a_floor_goes_with_robots_that_move():
    fixed = PLAIN.replace('"moving", density = 2', '"ring"').replace("FLOOR", '"half"')
    with pytest.raises(sc.InputError, match=r"world\.floor"):
        sc.Study.parse(fixed)
    with pytest.raises(sc.InputError, match=r"measure.truth = .*'nominal'"):
        sc.Study.parse(PLAIN.replace("FLOOR", '"half"') + '[measure]\ntruth = "tiles"\n')
