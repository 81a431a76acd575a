"""What was probably meant by a name that is not known."""

from collections.abc import Iterable

OTHER_WORDS = {
    "accuracy": ("b", "p", "sensor", "sensor_accuracy", "w"),
    "at": ("from", "round", "start", "tick", "when"),
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
    found += difflib.get_close_matches(plain, names, n=1)
    return f"did you mean {names[found[0]]!r}? " if found else ""


def _plain(name: str) -> str:
    return name.lower().lstrip("-").replace("-", "_").replace(" ", "_")
