"""What was probably meant by a name that is not known."""

import re
from collections.abc import Collection, Iterable
from pathlib import Path

OTHER_WORDS = {
    "accuracy": ("b", "p", "sensor", "sensor_accuracy", "w"),
    "at": ("from", "round", "start", "tick", "when"),
    "convergence_error": ("error",),
    "convergence_round": ("k",),
    "compare": ("rank", "versus", "vs"),
    "density": ("d",),
    "fill_ratio": ("black", "f"),
    "jobs": ("cores", "processes", "threads", "workers"),
    "minimalistic": ("default", "paper"),
    "observations_per_round": ("looks", "r"),
    "robots": ("n", "size", "swarm_size"),
    "rounds": ("c", "iterations", "length", "steps", "time"),
    "seed": ("random_seed", "rng", "rng_seed"),
    "show": ("cat", "info", "print", "summary", "table"),
    "ticks": ("iterations", "length", "steps", "time"),
    "topology": ("graph", "net", "network"),
    "trials": ("repeats", "repetitions", "replicates", "reps", "runs"),
}  # what people write who know the paper's letters, or another program
PART = 0.8  # how like a part of a name should be


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Such as "did you mean 'trials'? " for a name like one of the known, or another word for it; else nothing.

    Case, dashes and spaces do not count. There is a blank at the end, for what the known names are.
    """
    import difflib

    names = {_plain(one): one for one in known}
    plain = _plain(name)
    words = {plain, f"{plain}s", plain.removesuffix("s")}
    found = [one for one in names if plain == one or words & {*OTHER_WORDS.get(one, ())}]
    found += [one for one in names if len(plain) > 2 and one.startswith(plain)]
    parts = {part: one for one in names for part in re.split(r"[_/.]", one)}  # as of "final_error" and "paper/local"
    like = [(one, one) for one in difflib.get_close_matches(plain, names, n=1)]
    like += [(one, parts[one]) for one in difflib.get_close_matches(plain, parts, n=1, cutoff=PART)]
    found += [whole for _, whole in sorted(like, key=lambda one: -difflib.SequenceMatcher(None, plain, one[0]).ratio())]
    return f"did you mean {names[found[0]]!r}? " if found else ""


def did_you_mean_any(names: Iterable[object], known: Collection[str]) -> str:
    """The same of the first of several names that is not known and like one that is."""
    return next(filter(None, (did_you_mean(str(name), known) for name in names if name not in known)), "")


def did_you_mean_file(path: str | Path) -> str:
    """Such as "did you mean 'first.nc'? " where a file that is not there has a name like one beside it of its kind."""
    path = Path(path)
    try:
        beside = {one.stem: one for one in path.parent.iterdir() if one.suffix == path.suffix and one.is_file()}
    except OSError:
        return ""
    return did_you_mean(path.stem, beside).replace("'? ", f"{path.suffix}'? ")


def _plain(name: str) -> str:
    return name.lower().lstrip("-").replace("-", "_").replace(" ", "_")
