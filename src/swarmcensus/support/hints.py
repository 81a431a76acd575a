"""Suggestions for unknown names: "did you mean ...?"."""

import re
from collections.abc import Collection, Iterable
from pathlib import Path

OTHER_WORDS = {  # letters of the paper, and words of other programs
    "b": "accuracy", "w": "accuracy", "c": "rounds", "d": "density", "f": "fill_ratio", "k": "convergence_round",
    "n": "robots", "r": "observations_per_round", "rng": "seed", "steps": "rounds", "graph": "topology",
    "runs": "trials", "threads": "jobs", "gpu": "device", "cuda": "device", "summary": "show", "start": "at",
}  # fmt: skip
WHOLE, PART = 0.65, 0.8  # how similar a name, and a part of one, should be, from 0 to 1


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Such as "did you mean 'trials'? " for a name that resembles a known one or is a synonym of it; otherwise empty.

    Case, dashes and spaces are ignored. The text ends with a blank, because a list of the known names follows.
    """
    import difflib

    names = {_plain(known_name): known_name for known_name in known}
    plain = _plain(name)
    matches = [n for n in names if n in (plain, OTHER_WORDS.get(plain))]
    matches += [n for n in names if len(plain) > 2 and n.startswith(plain)]
    parts = {part: n for n in reversed(names) for part in re.split(r"[_/.]", n)}  # of "final_error", "a/b"
    near = [n for n in names if len(n) < 2 * len(plain)]
    similar = [(n, n) for n in difflib.get_close_matches(plain, near, n=1, cutoff=WHOLE)]
    similar += [(part, parts[part]) for part in difflib.get_close_matches(plain, parts, n=1, cutoff=PART)]
    matches += [n for _, n in sorted(similar, key=lambda pair: -difflib.SequenceMatcher(None, plain, pair[0]).ratio())]
    return f"did you mean {names[matches[0]]!r}? " if matches else ""


def did_you_mean_any(names: Iterable[object], known: Collection[str]) -> str:
    """`did_you_mean` for the first unknown name that resembles a known one."""
    return next(filter(None, (did_you_mean(str(name), known) for name in names if name not in known)), "")


def did_you_mean_file(path: str | Path, ending: str = "") -> str:
    """Such as "did you mean 'first.nc'? " for a missing file, if one next to it has a similar name.

    It has the `ending` of such files, by default that of the path.
    """
    path = Path(path)
    ending = (ending or path.suffix).lower()
    try:
        found = [file for file in path.parent.iterdir() if file.suffix.lower() == ending and file.is_file()]
    except OSError:
        return ""
    names = {file.stem: file.name for file in found}
    return re.sub(r"'(.+)'", lambda meant: repr(names[meant[1]]), did_you_mean(path.stem, names))


def _plain(name: str) -> str:
    return name.lower().lstrip("-").replace("-", "_").replace(" ", "_")
