"""Commands that one begins with: `new`, `studies`, `doctor`. Imports wait until needed."""

import argparse
import filecmp
import itertools
import re
import shlex
import shutil
from pathlib import Path

from swarmcensus.basics.errors import InputError
from swarmcensus.cli.output import answer, wrote

STARTERS = {"study": "study.toml", "brain": "brain.py"}
NEXT = {"study": "run", "brain": "brains --check"}  # what to do with them


def new(options: argparse.Namespace) -> int:
    """Write a commented file to begin with."""
    from swarmcensus.basics.files import whole

    starter = Path(__file__).parent / "starters" / STARTERS[options.what]
    out = options.file or _free(Path(f"my_{starter.name}"))
    if out.suffix != starter.suffix:
        raise InputError(f"{out}: a {options.what} is a {starter.suffix} file")
    _not_there(out)
    text = starter.read_text(encoding="utf-8").replace("THIS_FILE", out.name)
    with whole(out) as beside:
        beside.write_text(text.replace('name   = "mine"', f'name   = "{_plain(out.stem)}"'), encoding="utf-8")
    wrote(f"{out}: now swarmcensus {NEXT[options.what]} {shlex.quote(str(out))}")
    return 0


def studies(options: argparse.Namespace) -> int:
    """List the studies that come with swarmcensus, copy one with the files that it names, or print their schema."""
    from swarmcensus.basics.hints import did_you_mean
    from swarmcensus.basics.shipped import shipped_studies

    if options.schema:
        return _schema(options)
    known = shipped_studies()
    if options.name is None:
        if options.out:
            raise InputError(f"--out {options.out}: it goes with the name of a study, which is copied there")
        from swarmcensus.basics.terminal import console, table

        rows = [(name, _first_words(path)) for name, path in known.items()]
        if options.json:
            answer("studies", {"studies": [{"name": name, "what": what} for name, what in rows]})
            return 0
        console().print(table([("study", False), ("what it is", False)], rows))
        return 0
    if options.json:
        raise InputError(f"--json is of the list: it does not go with {options.name}, which is copied")
    name = options.name.removesuffix(".toml")
    if name not in known:
        hint = did_you_mean(name, known)
        raise InputError(
            f"{options.name}: no such study comes with swarmcensus: {hint}`swarmcensus studies` lists them"
        )
    _copy(known[name], options.out or Path(known[name].name))
    return 0


def _schema(options: argparse.Namespace) -> int:
    import json

    from swarmcensus.studies.schema import schema

    if options.out:
        raise InputError(f"--out {options.out}: a schema is printed: swarmcensus studies --schema > study.schema.json")
    print(json.dumps(schema(), indent=2, ensure_ascii=False))
    return 0


def _copy(study: Path, out: Path) -> None:
    """The files that a study names, then the study, which names them where they now lie: beside it."""
    if out.suffix != ".toml":
        raise InputError(f"--out {out}: a study is a .toml file")
    from swarmcensus.basics.files import whole

    text = study.read_text(encoding="utf-8")
    _not_there(out)
    copies = {name: _free(out.parent / Path(name).name, study.parent / name) for name in _named_by(study)}
    new = {name: copy for name, copy in copies.items() if not copy.exists()}
    for name, copy in new.items():
        with whole(copy) as beside:
            shutil.copyfile(study.parent / name, beside)
    for name, copy in copies.items():
        text = text.replace(f'"{name}"', f'"{copy.name}"')
    with whole(out) as beside:
        beside.write_text(text, encoding="utf-8")
    wrote(out)
    for name, copy in new.items():
        usual = Path(name).name
        wrote(copy if copy.name == usual else f"{copy}: there is another {usual} already, which stays as it is")


def _named_by(study: Path) -> list[str]:
    """Files that a study names, as brains, metrics or links."""
    import tomllib

    def words(value: object) -> list[str]:
        if isinstance(value, dict):
            return [word for one in value.values() for word in words(one)]
        if isinstance(value, list):
            return [word for one in value for word in words(one)]
        return [value] if isinstance(value, str) else []

    found = dict.fromkeys(words(tomllib.loads(study.read_text(encoding="utf-8"))))
    return [word for word in found if (study.parent / word).is_file()]


def _free(path: Path, like: Path | None = None) -> Path:
    """The path, or with a number the first that is not taken; one that holds what the file `like` does will do."""
    numbered = (path.with_stem(f"{path.stem}-{number}") for number in itertools.count(2))
    return next(one for one in itertools.chain([path], numbered) if _will_do(one, like))


def _will_do(path: Path, like: Path | None) -> bool:
    if not path.exists() and not path.is_symlink():
        return True
    return like is not None and path.is_file() and filecmp.cmp(path, like, shallow=False)


def _not_there(path: Path) -> None:
    if path.exists() or path.is_symlink():
        raise InputError(f"{path} is there already: name another file")


def _plain(stem: str) -> str:
    """What a study may be called."""
    return "".join(c if c.isalnum() or c in "-_" else "-" for c in stem)


def _first_words(study: Path) -> str:
    """The first sentence of the comment that a study begins with."""
    lines = []
    for line in study.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# "))
    words = re.split(r"(?<!Sec)[.?] (?=[A-Z`])|: (?=`)", " ".join(lines))[0]
    return words.rstrip(".:")


def doctor(options: argparse.Namespace) -> int:
    """Say what this installation is made of, and what is missing; 2 where compiled brains cannot be kept."""
    from swarmcensus.cli.health import health

    found = health()
    if options.json:
        answer("installation", found.told | {"faults": found.faults})
    else:
        from swarmcensus.basics.terminal import console, table

        console().print(table([("part", False), ("found", False)], [(k, str(v)) for k, v in found.lines()]))
        for fault in found.faults:
            print(f"\n{fault}")
    return 2 if found.faults else 0
