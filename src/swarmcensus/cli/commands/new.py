"""The command `new`: a commented study or brain to start from, or a copy of a shipped study."""

import filecmp
import logging
import os
import re
import shutil
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from swarmcensus.cli.messages import LOG
from swarmcensus.cli.parameters import FILE
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.files import atomic_write, shipped_studies
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import command as shell_line

STARTERS = {"study": "study.toml", "brain": "brain.py"}
NEXT = {"study": "run", "brain": "brains --check"}  # the command to use the new file with
WHAT = Parameter(metavar="study|brain|NAME", completer=lambda _: [*STARTERS, *shipped_studies()])


def new(what: Annotated[str, WHAT], file: Annotated[Path | None, FILE] = None, /) -> Answer:
    """Write a study or a brain to start from.

    Args:
        what: a commented study or brain, or a copy of the study NAME ('list studies') with the files that it uses
        file: file to write (default: my_study.toml, my_brain.py or NAME.toml)
    """
    files = _starter(what, file) if what in STARTERS else _copy(what, file)
    out, *_ = files
    name = [str(out)] * (not file and not LOG.isEnabledFor(logging.INFO))  # with --quiet too: the command chose it
    return Answer(sentences=name, files=files, next=shell_line("swarmcensus", *NEXT.get(what, "run").split(), out))


def _starter(what: str, file: Path | None) -> dict[Path, str]:
    """Write a commented study or brain."""
    starter = Path(__file__).parents[1] / "starters" / STARTERS[what]
    out = file or Path(f"my_{starter.name}")
    if out.suffix.lower() != starter.suffix:
        raise InputError.of(out, f"a {what} is a {starter.suffix} file")
    _not_there(out)
    name = "".join(c if c.isalnum() or c in "-_" else "-" for c in out.stem)  # as a study may be called
    text = starter.read_text(encoding="utf-8").replace("THIS_FILE", out.name)
    with atomic_write(out) as temporary:
        temporary.write_text(text.replace('name   = "mine"', f'name   = "{name}"'), encoding="utf-8")
    return {out: ""}


def _copy(what: str, file: Path | None) -> dict[Path, str]:
    """Copy a shipped study and the files that it uses to one folder, and adapt their names in the study."""
    known = shipped_studies()
    study = known.get(what.removesuffix(".toml"))
    if study is None:
        hint = did_you_mean(what.removesuffix(".toml"), [*STARTERS, *known])
        if not hint and (meant := [one for one, name in STARTERS.items() if what.endswith(Path(name).suffix)]):
            hint = f"did you mean '{shell_line('swarmcensus', 'new', meant[0], Path(what))}'? "
        there = f"{hint}should be study, brain, or a name of 'swarmcensus list studies'"
        raise InputError.of(shell_line(what), f"no such study comes with swarmcensus: {there}")
    out = file or Path(study.name)
    if out.suffix.lower() != ".toml":
        raise InputError.of(out, "a study is a .toml file")
    text = study.read_text(encoding="utf-8")
    _not_there(out)
    copies = {name: out.parent / Path(name).name for name in _files_of(study)}
    missing = {name: copy for name, copy in copies.items() if not os.path.lexists(copy)}
    for name, copy in copies.items():
        if name not in missing and not (copy.is_file() and filecmp.cmp(study.parent / name, copy, shallow=False)):
            raise InputError(f"another {copy} exists, and the study needs its own: name a file elsewhere", file=copy)
        text = text.replace(f'"{name}"', f'"{copy.name}"')
    for name, copy in missing.items():
        with atomic_write(copy) as temporary:
            shutil.copyfile(study.parent / name, temporary)
    with atomic_write(out) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return dict.fromkeys((out, *missing.values()), "")


def _files_of(study: Path) -> list[str]:
    """The files that a study uses, such as brains, metrics or links, as it names them."""
    texts = dict.fromkeys(re.findall(r'"([^"\n]+)"', study.read_text(encoding="utf-8")))
    return [text for text in texts if (study.parent / text).is_file()]


def _not_there(path: Path) -> None:
    if os.path.lexists(path):
        raise InputError(f"{path} already exists: name another file", file=path)
