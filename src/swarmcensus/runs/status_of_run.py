"""The progress of a study, from its output and the shards next to it, while it runs or after it was cut off."""

import json
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from swarmcensus.results import failed_in, folder_of, load_packed, shards
from swarmcensus.runs.progress import clock
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import ResultsError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import command

HOW_TO_CONTINUE = "the same swarmcensus run goes on from here"


@dataclass(repr=False)
class Status(Answer):
    """The progress of a study."""

    study: str
    settings: int
    done: int  # trials
    total: int
    running: str = ""  # the process that runs it; empty if none does
    seconds_left: float | None = None  # of the running process; None if unknown
    damaged: list[Path] = field(default_factory=list)
    failed: int = 0
    rule: str = ""  # the rule until which trials are still added
    share: str = ""  # the progress of a machine's share
    how_to_continue: str = ""  # how to continue, if the study is neither running nor done

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """The status as plain data, by the names that a summary uses."""
        return {
            "title": self.study, "settings_total": self.settings, "trials_done": self.done, "trials_total": self.total,
            "trials_failed": self.failed, "running": self.running or None, "seconds_left": self.seconds_left,
            "rule": self.rule or None, "share": self.share or None, "how_to_continue": self.how_to_continue or None,
            "damaged": self.damaged,
        }  # fmt: skip

    @property
    def sentences(self) -> list[str]:  # type: ignore[override]
        """The status in words."""
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
        elif self.how_to_continue:
            out.append(f"not running: {self.how_to_continue}")
        out += [f"{path} is damaged: what it held will be run again" for path in self.damaged]
        if self.failed:
            out.append(f"{counted(self.failed, 'trial')} failed: see the attribute `failed`")
        return out


def status(out: str | Path) -> Status:
    """The progress of the study that writes `out`. Raises InputError if there are no results and no run."""
    out = Path(out)
    folder = folder_of(out)
    if (folder / "run.json").is_file():
        return _status_of_run(out, folder)
    data = load_packed(out)
    done, total, failed = int(data.attrs["trials_done"]), int(data.attrs["trials_total"]), len(failed_in(data))
    rule = str(data["half_width"].attrs.get("rule", "")) if "half_width" in data and done + failed < total else ""
    share, how_to_continue = "", HOW_TO_CONTINUE if done < total else ""
    if "merged" in data.attrs and how_to_continue:
        texts = json.loads(data.attrs["merged"])
        which = "its study" if len(texts) == 1 else f"one study that holds all settings of the {len(texts)} merged"
        how_to_continue = f"swarmcensus run of {which}, with {command('--out', out)}, goes on from here"
    elif "share" in data.attrs and how_to_continue:
        share = f"share {data.attrs['share']}, which swarmcensus merge puts together with the others"
    return Status(
        str(data.attrs["title"]), data.sizes["setting"], done, total, failed=failed, rule=rule, share=share,
        how_to_continue=how_to_continue,
    )  # fmt: skip


def _status_of_run(out: Path, folder: Path) -> Status:
    try:
        about = json.loads((folder / "run.json").read_text(encoding="utf-8"))
        found, total = int(about["found"]), int(about["total"])
        before, work = set(about["shards"]), float(about["work"])
        name, settings, rule = str(about["study"]), int(about["settings"]), str(about["rule"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        file = folder / "run.json"
        why = f"{file} is damaged ({error!r}): the same swarmcensus run mends it"
        raise ResultsError(why, file=file) from None
    damaged, wall, worked = [], 0.0, 0.0
    for path in shards.shard_files(folder):
        shard = shards.read(path)
        if shard is None:
            damaged.append(path)
        elif path.name not in before:
            found += sum(len(piece.columns["convergence_round"]) for piece in shard.found if not piece.local)
            wall += shard.about["wall_seconds"]
            worked += shard.about["work"]
    running = shards.owner(folder)
    left = max(0.0, (work - worked) * wall / worked) if running and worked else None
    share = f"share {about['share']}: these are its trials" if about.get("share") else ""
    how = f"{about['command']} goes on from here" if about.get("command") else HOW_TO_CONTINUE
    return Status(name, settings, found, total, running, left, damaged, rule=rule, share=share, how_to_continue=how)
