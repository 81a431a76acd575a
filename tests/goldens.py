"""What shipped studies come to, written as text files, so that two trees can be compared to the last bit.

    python tests/goldens.py before        # in one tree
    python tests/goldens.py after         # in another one, or later
    diff -r before after

Each shipped study is run in few trials. A file of it holds a hash of every variable, the file's attributes, and what
the command line prints of it as tables and as JSON; of the studies in `WHOLE` also exports and figures. Other files
hold the fingerprints and random keys of all settings, plans, a tuned brain, pages, schemas and hashes of pictures.
Numbers are the same to the last bit only on the same machine with the same libraries. It takes a quarter of an hour on
two cores; `python tests/goldens.py FOLDER ring paper` writes only the files that have such a word in their names.
"""

import contextlib
import hashlib
import io
import json
import os
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
WHOLE = {
    "ring": 8, "sizes": 2, "steering": 2, "theory": 4, "wrong-beliefs": 2, "paper/local": 6, "paper/same-rounds": 2,
    "rivals/opinions": 2, "rivals/bayesian": 2, "rivals/consensus": 2, "beyond/changing": 2,
    "beyond/unknown-sensors": 2, "example/compare": 8, "example/floors": 2, "example/liars": 6, "example/recorded": 2,
}  # fmt: skip  # studies whose exports and figures are written too, with how many trials each is run
TRIALS = 2  # of the others
KEYS = ("readings_key", "losses_key", "draw_keys", "floor_key", "walk_key")  # addresses of a setting's random numbers
TIMES = ("started", "finished", "wall_seconds", "cpu_seconds")  # attributes of a file
VERSIONS = re.compile(r"\d+\.\d+\.\d+\S*|\d+(\.\d+)? (s|min|ms|MB|KB)\b|\d{4}-\d\d-\d\d[T ]\d\d:\d\d\S*")


def printed(*arguments: object) -> str:
    """What the command prints on stdout, and how it ended; times and versions are left out."""
    from swarmcensus.cli.commands import main

    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([*map(str, arguments)])
    said = err.getvalue() if code else ""
    return f"$ {' '.join(map(str, arguments))}\n{VERSIONS.sub('#', out.getvalue() + said)}-> {code}\n\n"


def digest(data: bytes) -> str:
    """A short hash."""
    return hashlib.sha256(data).hexdigest()[:16]


def values(path: Path) -> str:
    """The variables, coordinates and attributes of a results file, a line each."""
    import swarmcensus as sc

    data = sc.load(path)
    lines = []
    for name in sorted(map(str, data.variables)):
        array = data[name].values
        text = json.dumps(array.tolist()).encode() if array.dtype.kind in "OU" else array.tobytes()
        said = {k: str(v) for k, v in sorted(data[name].attrs.items())}
        lines.append(f"{name} {data[name].dims} {array.shape} {array.dtype.kind} {digest(text)} {said}")
    for name, said in sorted(item for item in data.attrs.items() if item[0] not in TIMES):
        lines.append(f"@{name} {VERSIONS.sub('#', str(said))}")
    return "\n".join(lines) + "\n\n"


def picture(path: Path) -> str:
    """The hash of a picture's pixels."""
    from PIL import Image

    return f"{path.name} {digest(Image.open(path).tobytes())}\n"


def names() -> list[str]:
    """All shipped studies, by their paths without the ending."""
    files = (ROOT / "studies").rglob("*.toml")
    return sorted(str(path.relative_to(ROOT / "studies").with_suffix("")) for path in files)


def addresses(name: str) -> str:
    """What each setting of a study is called, its coordinates, its fingerprint and its random keys, a line each."""
    import swarmcensus as sc
    from swarmcensus.studies import addresses as keys_of
    from swarmcensus.studies.coordinates import coordinates_of

    study = sc.Study.load(ROOT / "studies" / f"{name}.toml")
    lines = []
    for setting in study.settings():
        moves = setting.body is not None
        keys = [
            getattr(keys_of, key)(setting, study.seed) for key in KEYS if moves or key not in ("floor_key", "walk_key")
        ]
        words = " ".join(digest(np.asarray(key).tobytes()) for key in keys)
        lines.append(f"{setting} {coordinates_of(setting)} {keys_of.fingerprint(setting, study.seed)} {words}")
    return f"{name}: {len(lines)} settings\n" + "\n".join(lines) + "\n\n"


def of_study(name: str) -> str:
    """All that is written of a study."""
    results, trials = Path(name.replace("/", "-") + ".nc"), WHOLE.get(name, TRIALS)
    text = printed("run", ROOT / "studies" / f"{name}.toml", "--out", results, "--trials", trials, "--jobs", 2)
    text = text.replace(str(ROOT), "")
    if not results.exists():
        return text
    text += values(results)
    text += printed("show", results) + printed("compare", results, "--json")
    if name not in WHOLE:
        return text
    for command, *options in (("show", "--json"), ("compare",), ("explain",), ("explain", "--json")):
        text += printed(command, results, *options)
    text += printed("verify", results, "--seed", 1) + printed("verify", results, "--seed", 1, "--json")
    text += printed("explain", results, "--setting", 0)
    text += printed("compare", results, "--pairs", "--save", "pairs.csv")
    text += printed("compare", results, "--save", "worlds.tex")
    text += "".join(file.read_text() for file in map(Path, ("pairs.csv", "worlds.tex")) if file.exists())
    printed("export", results, "--out", "rows.csv")
    text += f"export {digest(Path('rows.csv').read_bytes())}\n"
    for kind in ("scatter", "lines", "heatmap", "compare"):
        of_lines = ((), ("--x", "checkpoint"), ("--x", "checkpoint", "--theory"))
        for options in {"scatter": ((), ("--theory",)), "lines": of_lines}.get(kind, ((),)):
            picture_of = Path(f"{kind}.png")
            text += printed("plot", results, "--kind", kind, "--out", picture_of, *options)
            text += picture(picture_of) if picture_of.exists() else ""
            picture_of.unlink(missing_ok=True)
    for file in map(Path, ("pairs.csv", "worlds.tex", "rows.csv")):
        file.unlink(missing_ok=True)
    return text


def of_the_rest() -> dict[str, str]:
    """Texts by the names of their files."""
    example = ROOT / "studies" / "example"
    shutil.copy(example / "my_brain.py", "my_brain.py")
    keys = ("side=3", "accuracy=0.8", "fill_ratio=0.3", "error=0.1")
    plan = ("plan", *(word for key in keys for word in ("--set", key)), "--trials", 40, "--set")
    found = {
        "schemas": printed("new", "study", "--schema"),
        "lists": printed("list") + printed("brains") + printed("list", "--json"),
        "help": "".join(printed(*command, "--help") for command in _commands()),
        "plan": printed(*plan, "robots={choose=[5,40]}", "--set", "minutes=8", "--out", "few.toml")
        + printed(*plan, "robots=20", "--set", "minutes={choose=[1,20]}", "--out", "plan.toml", "--plot", "plan.png"),
        "tune": printed(
            *("tune", example / "tuning.toml", "--parameter", "prior=1:100:log", "--budget", 26, "--trials", 4),
            *("--out", "tuned.toml"),
        ),
        "watch": printed("watch", "--out", "watch.html", "--view", "tick=50", "--set", "robots=10"),
        "reproduce": printed("reproduce", "--trials", 2, "--out", "reproduction", "--only", "fig2", "fig5", "claims"),
        "replay": printed("replay", "ring.nc", "--setting", 0, "--trial", 1, "--out", "trace.csv", "--plot", "t.png"),
        "board": printed("leaderboard", "--trials", 1, "--out", "board", "my_brain.py"),
        "infer": printed(
            *("infer", example / "observations.csv", "--links", example / "links.csv", "--accuracy", 0.8),
            *("--out", "infer.csv"),
        ),
    }
    for name, text in found.items():
        found[name] = text.replace(str(ROOT), "")
    texts = ("few.toml", "plan.toml", "tuned.toml", "trace.csv", "infer.csv")
    pages = [*Path("reproduction").rglob("*.html"), *Path("board").rglob("*.md")]
    for path in [*map(Path, texts), *pages]:
        if path.exists():
            found[path.name.replace(".", "-")] = VERSIONS.sub("#", path.read_text()).replace(str(ROOT), "")
    pictures = [Path("plan.png"), Path("t.png"), Path("infer.png"), *Path("reproduction").rglob("*.png")]
    found["pictures"] = "".join(picture(p) for p in [*sorted(pictures), *sorted(Path("board").rglob("*.png"))])
    return found


def _commands() -> list[list[str]]:
    from swarmcensus.cli.help import COMMANDS

    return [[], *([name] for name in COMMANDS)]


def main() -> None:
    """Write the folder."""
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit("usage: python tests/goldens.py FOLDER [WORD ...]")
    folder, words = Path(sys.argv[1]).absolute(), sys.argv[2:]
    folder.mkdir(parents=True)
    work = folder / "files"  # what the commands write
    work.mkdir()
    os.chdir(work)
    os.environ |= {"SWARMCENSUS_TERMINAL": "160", "TERM": "dumb", "NO_COLOR": "1"}
    sys.path.insert(0, str(ROOT / "src"))
    wanted = [name for name in names() if not words or any(word in name for word in words)]
    write(folder, "settings", "".join(map(addresses, wanted)))
    for name in wanted:
        write(folder, name.replace("/", "-"), of_study(name))
    for name, text in ({} if words else of_the_rest()).items():
        write(folder, name, text)


def write(folder: Path, name: str, text: Any) -> None:
    """A file of the folder."""
    (folder / f"{name}.txt").write_text(text, encoding="utf-8")
    print(name, flush=True)


if __name__ == "__main__":
    main()
