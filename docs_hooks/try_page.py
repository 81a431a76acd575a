"""The page on which visitors try a brain: what it needs is made when the site is built, in files next to this one.

The engine records the worlds once. MicroPython runs brains in them, in the order of calls of the package's reference,
from which its functions are taken as they are. The live page draws the swarm.
"""

import ast
import base64
import functools
import hashlib
import inspect
import json
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files, InclusionLevel
from mkdocs.structure.pages import Page

from swarmcensus import brains
from swarmcensus.brains import adversary, adversary_source, contract
from swarmcensus.live import offer_of, pages
from swarmcensus.live.about_trial import scene_of
from swarmcensus.live.choices import wanted
from swarmcensus.live.frames import Show
from swarmcensus.live.sessions import form_of
from swarmcensus.simulation import reference, sampling
from swarmcensus.studies import Setting, Study, addresses, members
from swarmcensus.support.templates import render

HERE = Path(__file__).with_name("try")
PAGE, MARK = "try.md", "<!-- try -->"
MICROPYTHON = {  # the files of its package for browsers, version 1.27.0, and their SHA-256
    "micropython.mjs": "c2be87e7ba24e3b47d133022b009a66bff07f4720aa23d816d216ef8cc47014c",
    "micropython.wasm": "06338c955b03c5700aa0069015d3e392d76836ef8e2ce25bedbe59b88ccd373c",
}
CLASSIC = {  # what makes its module a classic script
    "import.meta.url": "self.location.href",
    "export default _createMicroPythonModule;": "",
    "export async function": "async function",
    'await import("path")': "{}",
    'await import("url")': "{}",
    "var wasmBinary,": "var wasmBinary=self.WASM,",
}
TAKEN = (  # from the package, for MicroPython
    reference.live, reference.is_done, reference.message_by, reference.speaks, reference.fixed, reference.give,
    contract.confidence_of, adversary_source.functions_source, adversary_source._fill_ratio,
    adversary_source._confidence, adversary_source._tuple, adversary_source._altered_message,
)  # fmt: skip
CONSTANTS = {
    "SAYS": adversary.SAYS, "MAY_HAVE": (*adversary.MAY_HAVE,), "VALUES": adversary_source.VALUES, "ROLES": contract.ROLES,
}  # fmt: skip
EMPTY = """\
MEMORY = {"t": 0.0, "n": 0.0}  # what a robot remembers
MESSAGE = ("t",)  # what it says


def observe(me, blacks, looks):  # it read its floor
    me.t += looks
    me.n += blacks


def broadcast(me):  # what it says now, as a tuple
    return (me.t,)


def receive(me, message):  # what another robot said
    pass


def fuse(me):  # it has heard all
    pass


def estimate(me):  # how much of the floor is black
    return 0.5 if me.t == 0.0 else me.n / me.t
"""
STUDY = """\
name   = "my_world"
seed   = 34
trials = 1

[swarm]
brain    = "{brain}"
robots   = {robots}
accuracy = {accuracy}

[world]
topology   = "{topology}"
fill_ratio = 0.55
{more}"""
MOVING = "side       = 3.0\n\n[world.body]\ntile = 0.1\n\n[schedule]\nticks = 2000\n"
FIXED = "\n[schedule]\nrounds                 = 1000\nobservations_per_round = 10\n"
WORLDS = {"moving": (25, MOVING), "ring": (30, FIXED), "scale-free": (30, FIXED)}
ACCURACIES = (0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95)
GRID = 8191  # positions are stored in as many steps


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the swarm's own page, which the page of the site shows in a frame, and a licence."""
    made = {"arena.html": arena(), "micropython-license.txt": (HERE / "micropython-license.txt").read_text()}
    for name, content in made.items():
        files.append(File.generated(config, f"try/{name}", content=content, inclusion=InclusionLevel.INCLUDED))
    return files


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Put editor and frame into their page."""
    if page.file.src_uri != PAGE:
        return markdown
    page.meta["hide"] = ["navigation", "toc"]
    texts = {name: (HERE / f"try.{name}").read_text(encoding="utf-8") for name in ("html", "css", "js")}
    data = json.dumps(offered()).replace("<", "\\u003c")
    parts = f"<style>\n{texts['css']}</style>\n{texts['html']}", f'<script id="try-data" type="application/json">{data}</script>'
    return markdown.replace(MARK, "\n".join([*parts, f"<script>\n{texts['js']}</script>"]))


def offered() -> dict[str, Any]:
    """What the page lets people choose."""
    shipped = {name: brains.load(name) for name in brains.shipped()}
    return {
        "brains": {name: one.source for name, one in shipped.items() if not (one.is_oracle or one.steers)} | {"empty": EMPTY},
        "adversaries": {name: adversary.load(name).source for name in adversary.PLUGINS.shipped},
        "studies": {name: study_text(name) for name in WORLDS},
        "accuracies": ACCURACIES,
    }


def study_text(world: str, brain: str = "my_brain.py", accuracy: object = "ACCURACY") -> str:
    """The study of a world."""
    robots, more = WORLDS[world]
    return STUDY.format(brain=brain, robots=robots, accuracy=accuracy, topology=world, more=more)


def arena() -> str:
    """The live page, with brains in MicroPython as the source of its frames."""
    worlds = {name: recorded(name) for name in WORLDS}
    for world in worlds.values():  # networks share their readings
        world["of"] = next(name for name, other in worlds.items() if other["readings"] == world["readings"])
    for name, world in worlds.items():
        world["readings"] = world["readings"] if world["of"] == name else {}
    programs = {"worker": _packed(worker().encode()), "program": _packed(program().encode()), "wasm": _packed(_own("micropython.wasm"))}
    at = pages.SCRIPTS.index("source.js") + 1
    scripts = [pages._joined(pages.SCRIPTS[:at]), (HERE / "arena.js").read_text(encoding="utf-8"), pages._joined(pages.SCRIPTS[at:])]
    style, script = pages._joined(pages.STYLES), "\n".join(scripts)
    sources = f"script-src '{pages._hash(script)}' 'wasm-unsafe-eval' blob:; style-src '{pages._hash(style)}'; img-src data:"
    licences = [*sorted(pages.PAGE.glob("*-license.txt")), HERE / "micropython-license.txt"]
    contents = {
        "name": "Try a brain", "style": style, "script": script,
        "policy": f"default-src 'none'; {sources}; worker-src blob:; base-uri 'none'",
        "data": json.dumps({"worlds": worlds, "programs": programs, "played": {"speed": "120"}}).replace("<", "\\u003c"),
        "licences": "\n".join(path.read_text(encoding="utf-8") for path in licences),
    }  # fmt: skip
    return render(pages.PAGE / "index.html.jinja", recording=contents)


def worker() -> str:
    """MicroPython and what runs it, as a classic script, which browsers also start from a folder on disk."""
    loader = _own("micropython.mjs").decode()
    for before, after in CLASSIC.items():
        loader = loader.replace(before, after)
    return f"{loader}\n{(HERE / 'worker.js').read_text(encoding='utf-8')}"


def program() -> str:
    """What MicroPython runs next to brains."""
    trees = [Plainer().visit(ast.parse(inspect.getsource(one))) for one in TAKEN]
    helpers = f"HELPERS = OrderedDict({[*adversary_source.HELPERS.items()]!r})"
    taken = [*(f"{name} = {value!r}" for name, value in CONSTANTS.items()), helpers, *map(ast.unparse, trees)]
    return (HERE / "swarm.py").read_text(encoding="utf-8").replace("# REFERENCE", "\n\n".join(taken))


class Plainer(ast.NodeTransformer):
    """Writes in simpler words what MicroPython does not know: match, formatted texts, lists with stars, annotations."""

    def visit_Match(self, node: ast.Match) -> ast.AST:
        """As comparisons."""
        self.generic_visit(node)
        rest: list[ast.stmt] = []
        for case in reversed(node.cases):
            tests = [ast.Compare(node.subject, [ast.Eq()], [case.pattern.value])] if isinstance(case.pattern, ast.MatchValue) else []
            tests += [case.guard] if case.guard else []
            rest = [ast.If(ast.BoolOp(ast.And(), [ast.Constant(True), *tests]), case.body, rest)]
        return rest[0]

    def visit_JoinedStr(self, node: ast.JoinedStr) -> ast.AST:
        """As a call of `format`."""
        self.generic_visit(node)
        text = "".join("{}" if isinstance(p, ast.FormattedValue) else p.value.replace("{", "{{").replace("}", "}}") for p in node.values)  # type: ignore[attr-defined]
        return ast.Call(ast.Attribute(ast.Constant(text), "format"), [p.value for p in node.values if isinstance(p, ast.FormattedValue)], [])

    def visit_List(self, node: ast.List) -> ast.AST:
        """As a sum."""
        self.generic_visit(node)
        if not any(isinstance(part, ast.Starred) for part in node.elts):
            return node
        parts = [ast.Call(ast.Name("list"), [p.value], []) if isinstance(p, ast.Starred) else ast.List([p]) for p in node.elts]
        return functools.reduce(lambda a, b: ast.BinOp(a, ast.Add(), b), parts)

    def visit_arg(self, node: ast.arg) -> ast.AST:
        """Without its type."""
        return ast.arg(node.arg)


def recorded(world: str) -> dict[str, Any]:
    """A world as the engine has it, for all accuracies."""
    offer = offer_of(Study.parse(study_text(world, "alone", ACCURACIES[4]), where=PAGE, context={"base": None}))
    trial = wanted(offer, {})
    setting, seed = trial.settings[0], trial.seed
    show = Show(offer.live(setting, seed, 0), trial.study.measure)
    found = {
        "scene": scene_of(show), "form": form_of(offer, trial), "liars": liars(setting, seed), "keys": keys(setting, seed),
        "delay": setting.body.message_delay if setting.body else 0, "looks": setting.observations_per_round,
        "truth": setting.fill_ratio,
    }  # fmt: skip
    readings = {}
    for accuracy in ACCURACIES:
        one = wanted(offer, {"accuracy": str(accuracy)}).settings[0]
        assert keys(one, seed) == found["keys"]
        trace = offer.live(one, seed, 0)
        if setting.body is None:
            readings[accuracy] = _packed(trace.blacks()[1:].astype(np.uint8).tobytes())
        else:
            readings[accuracy] = _packed(np.packbits(trace.dataset()["reading"].values[1:] == 1.0).tobytes())
    return found | {"readings": readings} | (moved(show) if setting.body else {})


def liars(setting: Setting, seed: int) -> list[int]:
    """The robots in the order in which they lie: of k liars these are the first k."""
    one_each = replace(setting, members=(members.Member(1),) * setting.robots)
    return [int(robot) for robot in np.argsort(sampling.groups(one_each, seed, 0, 1)[0])]


def keys(setting: Setting, seed: int) -> list[str]:
    """The keys of brains' random numbers."""
    return list(map(str, addresses.draw_keys(replace(setting, brain=brains.load("voter")), seed)))


def moved(show: Show) -> dict[str, Any]:
    """Where robots are, what they stand on, and who hears whom.

    `moved` has differences from tick to tick of x, y and heading (what, robot, tick), after `start`. `turned` has bits
    (robot or pair, tick), 1 where it changes whether a robot reads, whether it is on black, and who are in reach.
    """
    trace, half = show.trace.dataset(links=True), show.setting.arena_side / 2
    places = np.round((trace["position"].values + half) / (2 * half) * GRID)
    turns = np.round(trace["heading"].values / (2 * np.pi) * 256)[..., np.newaxis]
    path = np.concatenate([places, turns], axis=2).astype(np.int64).transpose(2, 1, 0)
    near = np.zeros((show.rounds + 1, *(show.setting.robots,) * 2), np.bool_)
    near[tuple(trace["link"].values.T)] = True
    among = near[:, *np.triu_indices(show.setting.robots, 1)]
    bits = np.concatenate([trace["looked"].values == 1, trace["tile"].values == 1, among], axis=1)
    turned = np.diff(bits, axis=0, prepend=False).T
    steps = np.diff(path, axis=2)
    steps[2] = (steps[2] + 128) % 256 - 128
    return {"start": (path[..., 0] % [[GRID + 1], [GRID + 1], [256]]).tolist(), "moved": _packed(steps.astype(np.int8).tobytes()), "turned": _packed(np.packbits(turned, axis=1).tobytes())}


def _own(name: str) -> bytes:
    """A file of MicroPython, the one that was looked at."""
    content = (HERE / name).read_bytes()
    if hashlib.sha256(content).hexdigest() != MICROPYTHON[name]:
        raise ValueError(f"{HERE / name} is not the file of MicroPython that this page was made for")
    return content


def _packed(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content, 9)).decode()
