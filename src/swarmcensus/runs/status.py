"""How far a study is: read from its output and from the shards beside it, while it runs or after it was cut off."""

import json
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.formatting import counted
from swarmcensus.results import shards
from swarmcensus.results.store import load
from swarmcensus.results.structure import failures, finished
from swarmcensus.runs.progress import clock

GOES_ON = "the same swarmcensus run goes on from here"


@dataclass(frozen=True)
class Status:
    """How far a study is."""

    study: str
    settings: int
    done: int  # trials
    total: int
    running: str = ""  # by whom; empty where no run is at work
    seconds_left: float | None = None  # of a run that is at work; None where that cannot be said
    damaged: list[Path] = field(default_factory=list)
    failed: int = 0
    rule: str = ""  # trials are still added until it holds
    share: str = ""  # how far the share of a machine is, where it ran no more
    goes_on: str = ""  # how, where it is neither running nor done

    @property
    def told(self) -> dict[str, Any]:
        """The same as JSON takes it, by the names that a summary has for it."""
        return {
            "title": self.study, "settings_total": self.settings, "trials_done": self.done, "trials_total": self.total,
            "trials_failed": self.failed, "running": self.running or None, "seconds_left": self.seconds_left,
            "rule": self.rule or None, "share": self.share or None, "goes_on": self.goes_on or None,
            "damaged": self.damaged,
        }  # fmt: skip

    @property
    def lines(self) -> list[str]:
        """The same in words."""
        part = f" ({100 * self.done / self.total:.1f} %)" if self.total and not self.rule else ""
        trials = counted(self.done, "trial") if self.rule else f"{self.done:,} of {counted(self.total, 'trial')}"
        out = [f"{self.study}: {counted(self.settings, 'setting')}; {trials} done{part}"]
        out += [f"trials are added until: {self.rule}"] if self.rule else []
        out += [self.share] if self.share else []
        if self.running:
            out.append(f"running: {self.running}")
            if self.seconds_left is not None:
                end = time.strftime("%Y-%m-%d %H:%M", time.localtime(time.time() + self.seconds_left))
                out.append(f"about {clock(self.seconds_left)} left{' of this stage' * bool(self.rule)}: ends {end}")
        elif self.goes_on:
            out.append(f"not running: {self.goes_on}")
        out += [f"{path} is damaged: what it held will be run again" for path in self.damaged]
        if self.failed:
            out.append(f"{counted(self.failed, 'trial')} failed: see the attribute `failed`")
        return out


def status(out: str | Path) -> Status:
    """How far the study is that writes `out`. Raises InputError where there is nothing of it."""
    out = Path(out)
    if out.is_dir():
        raise InputError(f"results file {out}: it is a folder")
    folder = shards.folder_of(out)
    if (folder / "run.json").is_file():
        return _of_run(out, folder)
    if not out.is_file():
        raise InputError(f"{out}: there is no such file, and no run that writes it")
    data = load(out)
    done, total, failed = int(data.attrs["trials_done"]), int(data.attrs["trials_total"]), len(failures(data))
    rule = str(data["half_width"].attrs.get("rule", "")) if "half_width" in data and done + failed < total else ""
    share, goes_on = "", GOES_ON if done < total else ""
    if "merged" in data.attrs and goes_on:
        texts = json.loads(data.attrs["merged"])
        which = "its study" if len(texts) == 1 else f"one study that holds all settings of the {len(texts)} merged"
        goes_on = f"swarmcensus run of {which}, with --out {out}, goes on from here"
    elif "share" in data.attrs and goes_on:
        tried, wanted = _of_share(data)
        share = f"share {data.attrs['share']}: {tried:,} of its {counted(wanted, 'trial')} done"
        if tried == wanted:
            goes_on = "this share is done, swarmcensus merge puts it together with the others"
    return Status(
        str(data.attrs["title"]), data.sizes["setting"], done, total, failed=failed, rule=rule, share=share,
        goes_on=goes_on,
    )  # fmt: skip


def _of_share(data: xr.Dataset) -> tuple[int, int]:
    """How many trials of a machine's share there are, and how many it has."""
    k, n = map(int, data.attrs["share"].split("/"))
    trials = int(data.attrs["trials_total"]) // data.sizes["setting"]
    mine = np.isin(data["trial"].values, np.arange(trials)[trials * (k - 1) // n : trials * k // n])
    return int(finished(data)[:, mine].sum()), int(mine.sum()) * data.sizes["setting"]


def _of_run(out: Path, folder: Path) -> Status:
    try:
        about = json.loads((folder / "run.json").read_text(encoding="utf-8"))
        found, total = int(about["found"]), int(about["total"])
        before, work = set(about["shards"]), float(about["work"])
        name, settings, rule = str(about["study"]), int(about["settings"]), str(about["rule"])
        holder = f"process {about['process']} on {about['host']}, since {about['since']}"
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{folder / 'run.json'} is damaged ({error!r}): the same swarmcensus run mends it") from None
    damaged, wall, worked = [], 0.0, 0.0
    for path in shards.listed(folder):
        shard = shards.read(path)
        if shard is None:
            damaged.append(path)
        elif path.name not in before:
            found += sum(len(one.columns["convergence_round"]) for one in shard.found if not one.local)
            wall += shard.about["wall_seconds"]
            worked += shard.about["work"]
    running = holder if shards.is_busy(folder) else ""
    left = max(0.0, (work - worked) * wall / worked) if running and worked else None
    share = f"share {about['share']}: these are its trials" if about.get("share") else ""
    return Status(name, settings, found, total, running, left, damaged, rule=rule, share=share, goes_on=GOES_ON)
