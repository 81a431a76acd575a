"""The page on which visitors try a brain: what MicroPython computes in a browser is what the engine computes."""

import contextlib
import hashlib
import runpy
import tomllib

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.simulation import Stepped
from swarmcensus.studies import Study
from swarmcensus.translation import selftest
from tests.support.browsing import BROWSER, until
from tests.support.places import ROOT

pytest.importorskip("mkdocs", reason="pip install '.[docs]'")
HOOK = ROOT / "docs_hooks" / "try_page.py"
needs_browser = pytest.mark.skipif(BROWSER is None, reason="no Chromium here")
SHIPPED = [name for name in brains.shipped() if name not in ("oracle", "leaver")]
FILES = {  # of MicroPython 1.27.0, by their SHA-256
    "micropython.mjs": "c2be87e7ba24e3b47d133022b009a66bff07f4720aa23d816d216ef8cc47014c",
    "micropython.wasm": "06338c955b03c5700aa0069015d3e392d76836ef8e2ce25bedbe59b88ccd373c",
}
DONE = "$('#try-status').textContent.startsWith('Computed') || !$('#try-error').hidden"
DONE = DONE.replace("$", "document.querySelector")
LIES = ["always-black", "creeper", "forger", "jammer", "noisy-mirror", "random", "shouter", "slow-liar"]


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """The page in a folder on disk, without the site around it."""
    folder, hook = tmp_path_factory.mktemp("site"), runpy.run_path(str(HOOK))
    (folder / "arena.html").write_text(hook["arena"](), encoding="utf-8")
    (folder / "try.html").write_text(f"<!doctype html><meta charset=utf-8><body>{hook['editor']()}", encoding="utf-8")
    return (folder / "try.html").as_uri()


@pytest.fixture
def page(browser, address):
    """A page that must not complain."""
    context = browser.new_context(viewport={"width": 390, "height": 844})
    made, complaints = context.new_page(), []
    made.on("pageerror", lambda error: complaints.append(str(error)))
    made.address = address
    yield made
    context.close()
    assert complaints == []


def shown(page, **choices):
    """What robots believe (round, robot) after a run, and what the page complains of."""
    page.goto("about:blank")
    page.goto(f"{page.address}#{'&'.join(f'{key}={value}' for key, value in choices.items())}")
    return ran(page)


def ran(page):
    page.wait_for_function(DONE, timeout=300_000)
    frame = next(one for one in page.frames if "arena.html" in one.url)
    return np.array(frame.evaluate("[...(state.source.estimates || [])]")), page.inner_text("#try-error")


def saved(page, button):
    with page.expect_download() as download:
        page.click(button)
    return download.value.path().read_text()


def expected(study, folder):
    (folder / "my_world.toml").write_text(study)
    setting = Study.load(folder / "my_world.toml").settings()[0]
    return Stepped(setting, 34, 0, use=setting.use).estimates(0, setting.rounds + 1).ravel()


def test_micropython_is_the_one_that_was_looked_at_and_has_its_licence():
    found = {name: hashlib.sha256((HOOK.parent / "try" / name).read_bytes()).hexdigest() for name in FILES}
    assert found == FILES
    assert "Damien P. George" in (HOOK.parent / "try" / "micropython-license.txt").read_text()


@needs_browser
@pytest.mark.long
def test_a_saved_study_replays_to_the_bits_that_were_seen(page, tmp_path):
    seen, _ = shown(page, name="minimalistic", world="moving", accuracy=0.8, liars=3, adversary="shouter")
    (tmp_path / "my_brain.py").write_text(saved(page, "#try-file"))
    (tmp_path / "my_world.toml").write_text(saved(page, "#try-study"))
    assert tomllib.loads((tmp_path / "my_world.toml").read_text())["members"][0]["robots"] == 3
    with contextlib.chdir(tmp_path):
        results = sc.run(sc.Study.load("my_world.toml"), jobs=1)
        trace = sc.replay(results, setting=0, trial=0, brain_file="my_brain.py")
    np.testing.assert_array_equal(seen, trace["estimate"].values.ravel())


@needs_browser
@pytest.mark.long
@pytest.mark.parametrize("world", ["moving", "ring", "scale-free"])
def test_all_brains_are_those_of_the_engine(page, tmp_path, world):
    """The same bits, and where math.exp and the like are used 1e-12 in the first rounds."""
    for number, name in enumerate(SHIPPED):
        liars = 5 if number % 2 and name != "alone" else 0
        choices = {"liars": liars, "adversary": LIES[number // 2 % len(LIES)], "accuracy": 0.65 + number % 3 / 10}
        seen, complaint = shown(page, name=name, world=world, **choices)
        assert not complaint, (name, choices)
        (tmp_path / "my_brain.py").write_text(saved(page, "#try-file"))
        truth = expected(saved(page, "#try-study"), tmp_path)
        if selftest.is_exact(brains.load(name)):
            np.testing.assert_array_equal(seen, truth, err_msg=f"{name} {choices}")
        np.testing.assert_allclose(seen[:600], truth[:600], rtol=0, atol=1e-12, err_msg=f"{name} {choices}")


@needs_browser
@pytest.mark.long
def test_mistakes_have_their_line_and_links_hold_the_brain(page):
    first, _ = shown(page, name="commons", world="ring", accuracy=0.9)
    source = page.input_value("#try-brain")
    line = source.split("\n").index("def fuse(me):") + 2
    instead = "    pass\n\n\n{}\n\n\ndef rest(me):"
    for wrong, says in (
        ("    me.x = nothing", f"Line {line}: NameError: name 'nothing' isn't defined"),
        ("    import os", f"Line {line}: ImportError: a brain may import only math"),
        ("    import math as m\n    m.x = __import__.__globals__['_import']", f"Line {line + 1}: KeyError: _import"),
        ("    me.q = 1.0", f"Line {line}: me.q: a robot has only b, w and the fields of MEMORY and PARAMETERS"),
        ("    me.x = me.q", f"Line {line}: AttributeError: me.q: a robot has only b, w and the fields"),
        (instead.format("def broadcast(me):\n    return (0.0,) * 9"), "0.0), not a tuple of "),
        (instead.format('MESSAGE = "x"'), "MESSAGE is 'x': should be a tuple of names"),
        (instead.format('"""'), "SyntaxError"),
        ("    (", "SyntaxError"),
        ("    while True: pass", "did not return for 8 seconds"),
    ):
        page.fill("#try-brain", source.replace("def fuse(me):", f"def fuse(me):\n{wrong}"))
        page.press("#try-brain", "Control+Enter")
        until(page, "document.querySelector('#try-error').hidden", False)
        assert says in page.inner_text("#try-error")
    page.fill("#try-brain", f"{source}\n# é, my own")
    page.click("#try-share")
    until(page, "location.hash.includes('brain=')", True)
    page.address = page.url.split("#")[0]
    again, complaint = shown(page, **dict(part.split("=") for part in page.url.split("#")[1].split("&")))
    assert page.input_value("#try-brain").endswith("# é, my own")
    assert (complaint, page.input_value("#try-world")) == ("", "ring")
    np.testing.assert_array_equal(again, first)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390  # on a phone
    for part in (page.url.split("#")[1][:-30], "name=your own&world=ring", "brain=%%%"):
        page.evaluate("part => (location.hash = part)", part)
        until(page, "document.querySelector('#try-error').textContent", "This link is damaged.")
        assert page.input_value("#try-brain").endswith("# é, my own")
        page.click("#try-run")
        until(page, "document.querySelector('#try-error').hidden", True)
    _, complaint = shown(page, brain="abcd", world="ring")
    assert (complaint, page.input_value("#try-name")) == ("This link is damaged.", "minimalistic")
