"""How far a study is: read from its output and from the shards beside it, while it runs or after it was cut off."""

import json
import time
from dataclasses import dataclass
from pathlib import Path

from swarmcensus import shards
from swarmcensus.errors import InputError
from swarmcensus.progress import clock
from swarmcensus.results import load


@dataclass(frozen=True)
class Status:
    """How far a study is."""

    study: str
    settings: int
    done: int  # trials
    total: int
    running: str  # by whom; empty where no run is at work
    seconds_left: float | None  # of a run that is at work; None where that cannot be said
    damaged: list[Path]
    failed: int
    rule: str = ""  # trials are added until it holds

    @property
    def lines(self) -> list[str]:
        """The same in words."""
        share = f" ({100 * self.done / self.total:.1f} %)" if self.total else ""
        out = [f"{self.study}: {self.settings:,} settings; {self.done:,} of {self.total:,} trials done{share}"]
        if self.rule and self.done < self.total:
            out.append(f"trials are added until: {self.rule}; the total grows with them")
        if self.running:
            out.append(f"running: {self.running}")
            if self.seconds_left is not None:
                end = time.strftime("%Y-%m-%d %H:%M", time.localtime(time.time() + self.seconds_left))
                out.append(f"about {clock(self.seconds_left)} left: ends {end}")
        elif self.done < self.total:
            out.append("not running: the same swarmcensus run goes on from here")
        out += [f"{path} is damaged: what it held will be run again" for path in self.damaged]
        if self.failed:
            out.append(f"{self.failed} trials failed: see the attribute `failed`")
        return out


def status(out: str | Path) -> Status:
    """How far the study is that writes `out`. Raises InputError where there is nothing of it."""
    out = Path(out)
    folder = shards.folder_of(out)
    if (folder / "run.json").is_file():
        return _of_run(out, folder)
    if not out.is_file():
        raise InputError(f"{out}: there is no such file, and no run that writes it")
    data = load(out)
    done = int((data["convergence_round"].values[:, :, 0] >= 0).sum())
    total = int(data.attrs.get("trials_total", done))
    rule = str(data["half_width"].attrs.get("rule", "")) if "half_width" in data else ""
    failed = len(json.loads(data.attrs.get("failed", "[]")))
    return Status(str(data.attrs["title"]), data.sizes["setting"], done, total, "", None, [], failed, rule)


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
    return Status(name, settings, found, total, running, left, damaged, 0, rule)
