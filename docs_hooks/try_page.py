"""The page on which visitors try a brain: what it needs is made when the site is built, of files in `try/`.

The engine records worlds once, as saved pages have them, and MicroPython runs brains in them: functions of the
package's CPython reference give the order of calls. The live page draws the swarm.
"""

import ast
import base64
import functools
import inspect
import json
import re
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files, InclusionLevel
from mkdocs.structure.pages import Page

from swarmcensus import brains, cli
from swarmcensus.brains import adversary, adversary_source, contract
from swarmcensus.live import choices, offer_of, pages
from swarmcensus.live.about_trial import scene_of
from swarmcensus.live.frames import COLUMNS, Show
from swarmcensus.live.sessions import form_of
from swarmcensus.simulation import Stepped, reference, sampling
from swarmcensus.studies import Study, addresses
from swarmcensus.studies.members import Member
from swarmcensus.support.templates import render

MARK = "*The editor is on the documentation site.*"  # of the page
HERE = Path(__file__).with_name("try")
WORLDS = {path.stem: path.read_text(encoding="utf-8") for path in sorted((HERE / "worlds").glob("*.toml"))}
ACCURACIES = (0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95)
STARTER = Path(cli.__file__).with_name("starters") / "brain.py"
CLASSIC = {  # what turns MicroPython's module into a script that browsers also start from a folder on disk
    "import.meta.url": "self.location.href",
    "export default _createMicroPythonModule;": "",
    "export async function": "async function",
    'await import("path")': "{}",
    'await import("url")': "{}",
    "var wasmBinary,": "var wasmBinary=self.WASM,",
}
REFERENCE = ("live", "is_done", "message_by", "speaks", "fixed", "give")  # what MicroPython runs of these modules
OF_LIARS = ("functions_source", "confidence_of", "_fill_ratio", "_confidence", "_tuple", "_altered_message")
CONSTANTS = {
    "SAYS": adversary.SAYS, "MAY_HAVE": [*adversary.MAY_HAVE],
    "VALUES": adversary_source.VALUES, "ROLES": contract.ROLES,
}  # fmt: skip
DARK = re.compile(r"@media \(prefers-color-scheme: dark\) {\s*:root")  # in the style of the live page


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the swarm's own page, which the page of the site shows in a frame."""
    files.append(File.generated(config, "try/arena.html", content=arena(), inclusion=InclusionLevel.INCLUDED))
    return files


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Put the editor into its page."""
    if page.file.src_uri == "try.md":
        page.meta["hide"] = ["navigation", "toc"]
    return markdown.replace(MARK, editor()) if page.file.src_uri == "try.md" else markdown


def editor() -> str:
    """The editor and the frame of the swarm."""
    shipped = [brains.load(name) for name in brains.shipped()]
    data = {
        "brains": {one.name: one.source for one in shipped if not (one.is_oracle or one.steers)},
        "adversaries": {name: adversary.load(name).source for name in adversary.PLUGINS.shipped},
        "worlds": WORLDS, "accuracies": ACCURACIES,
    }  # fmt: skip
    data["brains"]["new"] = STARTER.read_text(encoding="utf-8")
    tags = f"<style>\n{_text('try.css')}</style>\n{_text('try.html')}", f"<script>\n{_text('try.js')}</script>"
    return f'{tags[0]}<script id="try-data" type="application/json">{_json(data)}</script>\n{tags[1]}'


def arena() -> str:
    """The live page, with brains in MicroPython as the source of its frames."""
    loader = functools.reduce(lambda text, change: text.replace(*change), CLASSIC.items(), _text("micropython.mjs"))
    texts = [f"{loader}\n{_text('worker.js')}".encode(), program().encode(), (HERE / "micropython.wasm").read_bytes()]
    at = pages.SCRIPTS.index("source.js") + 1
    script = "\n".join([pages._joined(pages.SCRIPTS[:at]), _text("arena.js"), pages._joined(pages.SCRIPTS[at:])])
    style = DARK.sub("@media all { :root.dark", pages._joined(pages.STYLES))
    hashes = f"script-src '{pages._hash(script)}' 'wasm-unsafe-eval' blob:; style-src '{pages._hash(style)}'"
    worlds = {name: recorded(name) for name in WORLDS}
    same = {name: next(one for one in WORLDS if worlds[one]["readings"] == worlds[name]["readings"]) for name in WORLDS}
    for name in same.keys() - same.values():  # networks share their readings
        worlds[name] = worlds[name] | {"readings": same[name]}
    recording = {"worlds": worlds, "programs": [*map(_packed, texts)], "settled": [None], "played": {"speed": "120"}}
    contents = {
        "name": "Try a brain", "style": style, "script": script, "data": _json(recording),
        "policy": f"default-src 'none'; {hashes}; img-src data:; worker-src blob:; base-uri 'none'",
        "licences": pages._joined(("konva-license.txt", "uPlot-license.txt")) + _text("micropython-license.txt"),
    }  # fmt: skip
    return render(pages.PAGE / "index.html.jinja", recording=contents)


def program() -> str:
    """What MicroPython runs next to brains."""
    made = [f"{name} = {value!r}" for name, value in CONSTANTS.items()]
    made += [f"HELPERS = OrderedDict({[*adversary_source.HELPERS.items()]!r})"]
    for module, names in ((reference, REFERENCE), (adversary_source, OF_LIARS)):
        made += [ast.unparse(Plainer().visit(ast.parse(inspect.getsource(getattr(module, name))))) for name in names]
    return _text("swarm.py").replace("# REFERENCE", "\n\n".join(made))


class Plainer(ast.NodeTransformer):
    """Writes in plainer words what MicroPython does not know: match, formatted texts, lists with stars."""

    def visit_Match(self, node: ast.Match) -> ast.AST:
        """As comparisons."""
        self.generic_visit(node)
        rest: list[ast.stmt] = []
        for case in reversed(node.cases):
            is_any = not isinstance(case.pattern, ast.MatchValue)
            test = ast.Constant(True) if is_any else ast.Compare(node.subject, [ast.Eq()], [case.pattern.value])
            rest = [ast.If(ast.BoolOp(ast.And(), [test, case.guard or ast.Constant(True)]), case.body, rest)]
        return rest[0]

    def visit_JoinedStr(self, node: ast.JoinedStr) -> ast.AST:
        """As a sum of texts."""
        self.generic_visit(node)
        parts = [p if isinstance(p, ast.Constant) else ast.Call(ast.Name("str"), [p.value], []) for p in node.values]
        return functools.reduce(lambda one, other: ast.BinOp(one, ast.Add(), other), parts)

    def visit_List(self, node: ast.List) -> ast.AST:
        """As a sum of lists."""
        self.generic_visit(node)
        starred = [isinstance(part, ast.Starred) for part in node.elts]
        parts = [part.value if star else ast.List([part]) for star, part in zip(starred, node.elts, strict=True)]
        return functools.reduce(lambda one, other: ast.BinOp(one, ast.Add(), other), parts) if any(starred) else node


class Still(Stepped):
    """A trial without its estimates, which brains on the page make."""

    def at(self, k: int) -> Any:
        """A stretch of it."""
        stretch = super().at(k)
        return replace(stretch, estimates=np.full_like(stretch.estimates, 0.5))


@functools.cache
def recorded(world: str) -> dict[str, Any]:
    """A world as the engine has it; its readings (round, robot) are how many were black, a bit each if robots move."""
    study = Study.parse(WORLDS[world].replace("my_brain.py", "alone"), where=world, context={"base": None})
    offer = replace(offer_of(study), live=Still)
    trial = choices.wanted(offer, {})
    setting, seed, readings = trial.settings[0], trial.seed, {}
    show = Show(Still(setting, seed, 0), study.measure)
    for accuracy in ACCURACIES:
        trace = Still(choices.wanted(offer, {"accuracy": str(accuracy)}).settings[0], seed, 0)
        blacks = trace.dataset()["reading"].values if trace.moves else trace.blacks()
        numbers = np.packbits(blacks[1:] == 1.0) if trace.moves else blacks[1:].astype(np.uint8)
        readings[accuracy] = _packed(numbers.tobytes())
    ranks = sampling.groups(replace(setting, members=(Member(1),) * setting.robots), seed, 0, 1)[0]
    luck = addresses.draw_keys(replace(setting, brain=brains.load("voter")), seed)
    return {
        "scene": scene_of(show), "form": form_of(offer, trial), "readings": readings, "keys": [*map(str, luck)],
        "frames": _packed(steps_of(show)),
        "liars": np.argsort(ranks).tolist(),  # of k liars these are the first k
        "delay": setting.body.message_delay if setting.body else 0,
        "looks": setting.observations_per_round,
    }  # fmt: skip


def steps_of(show: Show) -> bytes:
    """The frames of a trial, with estimates and places as differences from tick to tick, which compress well."""
    rounds = show.rounds + 1
    frames, planes = bytearray(show.frames([*range(rounds)])), 3 if show.moves else 1
    begin = 36 + rounds * 8 * (len(COLUMNS) + 1)  # what comes before: see live/frames.py
    places = np.frombuffer(frames, "<u2", rounds * planes * show.setting.robots, begin).reshape(rounds, -1)
    places[1:] = np.diff(places, axis=0)
    return bytes(frames)


def _text(name: str) -> str:
    return (HERE / name).read_text(encoding="utf-8")


def _json(data: Any) -> str:
    return json.dumps(data).replace("<", "\\u003c")


def _packed(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content, 9)).decode()
