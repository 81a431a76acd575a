"""The command `new`: a commented study or brain to start from, or a copy of a shipped study."""

import argparse
import itertools
import shutil
from collections.abc import Collection
from pathlib import Path

from swarmcensus.cli.options import Command, Group, add_shared

from swarmcensus.cli.output import print_schema, say, wrote
from swarmcensus.support.errors import InputError
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import command, misplaced

STARTERS = {"study": "study.toml", "brain": "brain.py"}
NEXT = {"study": "run", "brain": "brains --check"}  # the command to use the new file with


def add_new_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `new`."""
    sub.add_argument(
        "what",
        metavar="study|brain|NAME",
        help="a commented study, a commented brain, or a copy of the shipped study NAME with the files that it uses; "
        "'list studies' has the names",
    )
    sub.add_argument(
        "file",
        type=Path,
        nargs="?",
        metavar="FILE",
        help="file to write (default: my_study.toml, my_brain.py or NAME.toml in this folder, the first two with a "
        "number if they exist)",
    )
    add_shared(sub, schema="new study --schema")


def new(options: argparse.Namespace) -> int:
    """Write a commented study or brain to start from, or copy a shipped study."""
    from swarmcensus.support.files import atomic_write, shipped_studies

    if options.schema:
        return _schema(options)
    if options.what not in STARTERS:
        known = shipped_studies()
        name = options.what.removesuffix(".toml")
        if name not in known:
            there = f"{_hint(options.what, known)}should be study, brain, or a name of 'swarmcensus list studies'"
            raise InputError.of(command(options.what), f"no such study comes with swarmcensus: {there}")
        out = options.file or Path(known[name].name)
        _copy(known[name], out)
        _answer(options, out)
        return 0
    starter = Path(__file__).parents[1] / "starters" / STARTERS[options.what]
    out = options.file or _free(Path(f"my_{starter.name}"))
    if out.suffix.lower() != starter.suffix:
        raise InputError.of(out, f"a {options.what} is a {starter.suffix} file")
    _not_there(out)
    text = starter.read_text(encoding="utf-8").replace("THIS_FILE", out.name)
    with atomic_write(out) as temporary:
        temporary.write_text(text.replace('name   = "mine"', f'name   = "{_plain(out.stem)}"'), encoding="utf-8")
    wrote(f"{out}: next, swarmcensus {NEXT[options.what]} {command(out)}")
    _answer(options, out)
    return 0


def _answer(options: argparse.Namespace, out: Path) -> None:
    """Print the name of the file with --quiet too if the command chose it: then it is an answer."""
    if options.quiet and not options.file:
        print(out)


def _hint(what: str, known: Collection[str]) -> str:
    """What was probably meant: a known name, or a starter under the name of a file."""
    meant = next((name for name, file in STARTERS.items() if what.endswith(Path(file).suffix)), "")
    similar = did_you_mean(what.removesuffix(".toml"), [*STARTERS, *known])
    return similar if similar or not meant else f"did you mean '{command('swarmcensus', 'new', meant, Path(what))}'? "


def _schema(options: argparse.Namespace) -> int:
    from swarmcensus.studies import schema

    if options.what != "study" or options.file:
        raise misplaced("schema", None, "goes with study alone: swarmcensus new study --schema > study.schema.json")
    print_schema(schema())
    return 0


def _copy(study: Path, out: Path) -> None:
    """Copy a study and the files that it uses to one folder, and adapt their names in the study."""
    from swarmcensus.support.files import atomic_write

    if out.suffix.lower() != ".toml":
        raise InputError.of(out, "a study is a .toml file")
    text = study.read_text(encoding="utf-8")
    _not_there(out)
    copies = {name: _free(out.parent / Path(name).name, study.parent / name) for name in _files_of(study)}
    missing = {name: copy for name, copy in copies.items() if not copy.exists()}
    for name, copy in missing.items():
        with atomic_write(copy) as temporary:
            shutil.copyfile(study.parent / name, temporary)
    for name, copy in copies.items():
        text = text.replace(f'"{name}"', f'"{copy.name}"')
    with atomic_write(out) as temporary:
        temporary.write_text(text, encoding="utf-8")
    wrote(out)
    for name, copy in missing.items():
        usual = Path(name).name
        wrote(copy if copy.name == usual else f"{copy}: a different {usual} exists, and is kept")
    say(f"next: {command('swarmcensus', 'run', out)}")


def _files_of(study: Path) -> list[str]:
    """The files that a study uses, such as brains, metrics or links, as it names them."""
    from swarmcensus.studies import read_toml
    from swarmcensus.support.texts import read_text

    def strings(value: object) -> list[str]:
        if isinstance(value, dict):
            value = list(value.values())
        if isinstance(value, list):
            return [text for item in value for text in strings(item)]
        return [value] if isinstance(value, str) else []

    texts = dict.fromkeys(strings(read_toml(read_text(study, "study"), "study")))
    return [text for text in texts if (study.parent / text).is_file()]


def _free(path: Path, like: Path | None = None) -> Path:
    """The path, or the first with a number that does not exist yet or equals the file `like`."""
    numbered = (path.with_stem(f"{path.stem}-{number}") for number in itertools.count(2))
    return next(candidate for candidate in itertools.chain([path], numbered) if _usable(candidate, like))


def _usable(path: Path, like: Path | None) -> bool:
    if not path.exists() and not path.is_symlink():
        return True
    import filecmp

    return like is not None and path.is_file() and filecmp.cmp(path, like, shallow=False)


def _not_there(path: Path) -> None:
    if path.exists() or path.is_symlink():
        raise InputError(f"{path} already exists: name another file", file=path)


def _plain(stem: str) -> str:
    """A name that a study may have, from the stem of a file."""
    return "".join(c if c.isalnum() or c in "-_" else "-" for c in stem)


COMMANDS = (
    Command(
        "new", "Write a study or a brain to start from.",
        Group.STUDIES, 1, new, add_new_options, json=False,
    ),
)  # fmt: skip
