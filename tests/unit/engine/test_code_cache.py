"""Compiled code on disk: what is damaged is noticed and made anew, and gives the same numbers."""

import contextlib
import json
import os
import runpy
import subprocess
import sys

import pytest

from swarmcensus.engine import code_cache
from swarmcensus.support.owners import Owner
from tests.support.places import ROOT

TINY = """from numba import typeof
from swarmcensus.engine.calling import unpacked, unpacking
from swarmcensus.engine.compiling import entry

@entry
def double(x):
    return 2 * x

PAIR = 1.5, 2
KIND = typeof(PAIR)

@unpacking(*PAIR)
def product(pair):
    x, y = unpacked(pair, KIND)
    return x * y
"""
FILES = {"__init__.py": "", "tiny.py": TINY}
CODE = f"""
from swarmcensus.engine import code_cache
tiny = code_cache.module({FILES!r}, "tiny")
print(tiny.double(21), tiny.double(1.5), sum(tiny.double.stats.cache_hits.values()))
"""


FORKS = """
import json, os, sys
import numba
from swarmcensus.engine import code_cache, compiling
numba.njit(lambda x: 2 * x)(1)
for line in sys.stdin:
    code, words, environment, out = json.loads(line)
    if not os.fork():
        os.environ.update(environment)
        sys.argv[1:] = words
        os.dup2(os.open(out, os.O_CREAT | os.O_WRONLY), 1)
        os.dup2(1, 2)
        exec(code, {})
        sys.exit()
    print(os.wait()[1], flush=True)
"""


def with_numba(cache):
    return {"SWARMCENSUS_CACHE": str(cache), "NUMBA_DISABLE_JIT": "0"}


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Runs code in a process of its own, a copy of one that has compiled: what it prints."""
    if not hasattr(os, "fork"):
        pytest.skip("no process can be copied here")
    out = tmp_path_factory.mktemp("out") / "out"
    command, pipe, environment = [sys.executable, "-c", FORKS], subprocess.PIPE, os.environ | with_numba(out.parent)
    with subprocess.Popen(command, env=environment, stdin=pipe, stdout=pipe, text=True) as process:

        def ran(cache, *words, code=CODE, **more):
            out.unlink(missing_ok=True)
            print(json.dumps([code, words, with_numba(cache) | more, str(out)]), file=process.stdin, flush=True)
            assert process.stdout.readline() == "0\n", out.read_text()
            return out.read_text()

        yield ran
        process.stdin.close()


def flip(path):
    data = bytearray(path.read_bytes())
    data[2 * len(data) // 3] ^= 0x10  # of the machine code itself, and no pickle fails
    path.write_bytes(data)


DAMAGE = {
    "cut": lambda path: path.write_bytes(path.read_bytes()[: path.stat().st_size // 2]), "flip": flip,
    "empty": lambda path: path.write_bytes(b""), "other": lambda path: path.write_bytes(b"my notes"),
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory, ran):
    root = tmp_path_factory.mktemp("cache")
    assert (ran(root), ran(root)) == ("42 3.0 0\n", "42 3.0 2\n")
    return root / code_cache.folder_name(FILES)


@pytest.mark.long(but=["*.1.nbc-flip"])
@pytest.mark.parametrize(("name", "damage"), [
    ("tiny.py", "flip"), ("tiny.py", "cut"), ("*.nbi", "empty"), ("*.nbi", "other"), ("*.1.nbc", "flip"),
    ("*.1.nbc", "cut"), ("*.sha256", "other"),
])  # fmt: skip
def test_damaged_files_are_made_again(name, damage, folder, ran):
    (path,) = folder.rglob(name)
    DAMAGE[damage](path)
    assert ran(folder.parent) == "42 3.0 0\n"
    assert (folder / "tiny.py").read_text() == TINY


FULL = """
import errno, os, shutil, sys
from numba.core import caching
from swarmcensus.engine import code_cache
root = os.environ["SWARMCENSUS_CACHE"]
def fails(*_):
    raise OSError(getattr(errno, sys.argv[1]), "it fails")
def gone(*_):
    shutil.rmtree(root)
    return save(*_)
def read_only(locator):
    if locator.get_cache_path().startswith(root):
        raise OSError(errno.EROFS, "it fails")
    ensure(locator)
save, ensure = caching.IndexDataCacheFile._save_data, caching._CacheLocator.ensure_cache_path
if sys.argv[1] == "LATER":
    caching._CacheLocator.ensure_cache_path = read_only
else:
    caching.IndexDataCacheFile._save_data = gone if sys.argv[1] == "GONE" else fails
"""


@pytest.mark.long(but=["ENOSPC"])
@pytest.mark.parametrize("how", ["ENOSPC", "EDQUOT", "EIO", "EROFS", "GONE", "LATER"])
def test_a_disk_that_fails_while_something_is_compiled_is_no_fault_of_it(how, tmp_path, ran):
    """It fills, breaks, becomes read-only, or the cache is removed: once said, and all is compiled for this run."""
    said = ran(tmp_path / "cache", how, code=FULL + CODE, XDG_CACHE_HOME=str(tmp_path / "home"))
    assert "42 3.0 0\n" in said
    assert said.count("cannot be used: brains are compiled for this run alone") == 1


@pytest.mark.long(but=["None"])
@pytest.mark.parametrize("damage", [None, "flip", "native", "needs"])
def test_shipped_code_is_used_until_there_is_native_code(damage, tmp_path, ran):
    """But not where it is damaged, or needs another processor, and not by a process that makes native code."""
    made, shipped = tmp_path / "made", tmp_path / "shipped"
    generic = with_numba(made) | {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    subprocess.run([sys.executable, "-c", CODE], env=os.environ | generic, check=True)
    for name, code in runpy.run_path(str(ROOT / "tools" / "machine_code.py"))["collect"](made).items():
        path = shipped / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"" if path.name == "needs" else code)
    here = path.parents[1]
    if damage == "flip":
        for path in here.rglob("*.nbc"):
            flip(path)
    if damage == "needs":
        (here / "needs").write_text("no-such-feature")
    ahead = f"from swarmcensus.engine import code_cache\ncode_cache.SHIPPED = type(code_cache.HERE)({str(here)!r})\n"
    ahead += "code_cache.NATIVE.set()\n" * (damage == "native")
    for hits in ("2" if damage is None else "0", "2"):
        assert ran(tmp_path / "new", code=ahead + CODE) == f"42 3.0 {hits}\n"
    assert bool([*(tmp_path / "new").rglob("*.nbc")]) == (damage is not None)


def test_processes_share_one_compilation(tmp_path, ran):
    """One compiles beforehand what the other calls."""
    code = f"""
import os, time
from numba.core import caching
from swarmcensus.engine import code_cache
tiny = code_cache.module({FILES!r}, "tiny")
go, begin = os.pipe()
save = caching.IndexDataCacheFile._save_data
def slowly(*given):
    os.write(begin, b"!")
    time.sleep(0.3)
    return save(*given)
if other := os.fork():
    caching.IndexDataCacheFile._save_data = slowly
else:
    os.read(go, 1)
assert tiny.product.address() if other else tiny.product(10.5, 4) == 42.0
os.write(1, b"%d\\n" % sum(tiny.product.function.stats.cache_misses.values()))
os._exit(os.waitpid(other, 0)[1] if other else 0)
"""
    assert sorted(ran(tmp_path / "cache", code=code).split()) == ["0", "1"]


def test_a_full_disk_leaves_no_half_of_a_module(tmp_path, monkeypatch):
    def full(path, data):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_bytes", full)
    with pytest.raises(OSError, match="No space left"):
        code_cache._write_once(tmp_path / "module", {"one.py": "x = 1\n"})
    assert list(tmp_path.iterdir()) == []


def test_where_nothing_can_be_owned_all_is_compiled(tmp_path, monkeypatch):
    (tmp_path / "a_file").touch()
    monkeypatch.setattr(code_cache, "WAIT", 0.1)
    path = tmp_path / "brain_calls.owner"
    with contextlib.ExitStack() as held, Owner(path):  # of a process that compiles for ever
        code_cache._take(held, tmp_path / "a_file" / "brain_calls.owner")
        code_cache._take(held, path)
