"""Builds a wheel that carries machine code: python tools/machine_code.py DIST, with this project installed.

The wheel is for the platform and Python of this process, and its code for processors of some ten years, or on other
machines than x86-64 for any. It is used with the versions of Numba, llvmlite and NumPy that are installed here, and
with others only takes room.
"""

import base64
import hashlib
import os
import pickle
import platform
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

from swarmcensus.engine import code_cache

ROOT = Path(__file__).parents[1]
IS_X86 = platform.machine().lower() in ("x86_64", "amd64")
BASELINE = {"NUMBA_CPU_NAME": "x86-64-v3" if IS_X86 else "generic", "NUMBA_CPU_FEATURES": ""}
V3 = "avx avx2 bmi bmi2 cx16 f16c fma lzcnt movbe popcnt sahf sse3 sse4.1 sse4.2 ssse3 xsave"
PLACE = "swarmcensus/engine/machine_code"
MOST = 8_000_000  # bytes of the wheel
STUDY = """trials = 1
[swarm]
brain = {brains}
robots = 20
accuracy = [0.675, "U(0.525, 0.975)"]
[world]
topology = {topologies}
fill_ratio = 0.55
[schedule]
{length}
"""
BRAINS = '["minimalistic", "census", "commons", "steadfast", "sure"]'
STUDIES = {
    "networks": STUDY.format(brains=BRAINS, topologies='["ring", "full", "scale-free"]', length="rounds = 20"),
    "moving": STUDY.format(brains=BRAINS, topologies='["moving"]\ndensity = 2.0', length="ticks = 100"),
}


def compile_all(cache: Path) -> None:
    """Run what a new user may: code of whatever that needs is in the cache then."""
    environment = os.environ | BASELINE | {"SWARMCENSUS_CACHE": str(cache)}
    for name, text in STUDIES.items():
        (cache / f"{name}.toml").write_text(text, encoding="utf-8")
    runs = [("run", f"{name}.toml", "--out", f"{name}.nc") for name in STUDIES]
    shows = [("watch", f"{name}.toml", "--out", f"{name}.html") for name in STUDIES]
    for words in (*runs, *shows, ("reproduce", "--trials", "2")):
        subprocess.run([sys.executable, "-m", "swarmcensus", *words], cwd=cache, env=environment, check=True)


def collect(cache: Path) -> dict[str, bytes]:
    """The machine code of a cache, by its file in the package: each function with its hash before it."""
    carried = {f"{PLACE}/needs": V3.encode() if IS_X86 else b""}
    for index in sorted(cache.glob("*/__pycache__/*.nbi")):
        folder, stem = index.parents[1], index.name.partition(".")[0]
        code_cache._import_from(f"_swarmcensus_{folder.name}", folder, stem)  # what the index speaks of
        with index.open("rb") as file:
            pickle.load(file)  # Numba's version, which the folder's name holds
            _, kept = pickle.load(file)
        for (signature, *_), name in kept.items():
            code = (index.parent / name).read_bytes()
            place = f"{folder.name}/{code_cache.shipped_name(index.name.rpartition('-')[0], signature)}"
            carried[f"{PLACE}/{place}"] = hashlib.sha256(code).digest() + code
    return carried


def repacked(pure: Path, carried: dict[str, bytes], dist: Path) -> Path:
    """The wheel with more files, for one platform."""
    python = sys.implementation.cache_tag.replace("cpython-", "cp")
    tag = f"{python}-{python}-{sysconfig.get_platform().translate(str.maketrans('-.', '__'))}"
    made = dist / pure.name.replace("py3-none-any", tag)
    with zipfile.ZipFile(pure) as source:
        files = {name: source.read(name) for name in source.namelist()} | carried
    [record] = (name for name in files if name.endswith(".dist-info/RECORD"))
    kind = record.replace("RECORD", "WHEEL")
    files[kind] = files[kind].replace(b"py3-none-any", tag.encode()).replace(b"Purelib: true", b"Purelib: false")
    del files[record]
    rows = []
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=")
        rows.append(f"{name},sha256={digest},{len(content)}\n")
    files[record] = "".join([*rows, f"{record},,\n"]).encode()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as target:
        for name, content in files.items():
            target.writestr(name, content)
    return made


def main(dist: str) -> None:
    """Build it into a folder."""
    Path(dist).mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        cache, pure = Path(folder) / "cache", Path(folder) / "pure"
        cache.mkdir()
        compile_all(cache)
        subprocess.run([sys.executable, "-m", "pip", "wheel", "--no-deps", "-w", str(pure), str(ROOT)], check=True)
        made = repacked(*pure.glob("*.whl"), collect(cache), Path(dist))
    size = made.stat().st_size
    print(f"{made}: {size:,} bytes")
    if size > MOST:
        sys.exit(f"at most {MOST:,} bytes are wanted")


if __name__ == "__main__":
    main(sys.argv[1])
