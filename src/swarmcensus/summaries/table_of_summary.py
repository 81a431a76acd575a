"""A summary of results as an answer: a row for each setting, and what its columns mean."""

import functools
from collections.abc import Collection, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus.results import metrics_in, parameters_in, robots_in
from swarmcensus.studies import COORDINATES, NUMERIC
from swarmcensus.summaries import measures
from swarmcensus.summaries.cautions import AGREED_AT_START, failed_trials
from swarmcensus.summaries.labels import is_set, labels_in, studies_in
from swarmcensus.summaries.summaries import EMPTY_CELL, done_trials, records, repeated_coordinates, table_of, value_text
from swarmcensus.summaries.tails import TAIL_QUANTITY, shows_tail
from swarmcensus.support.answers import Answer
from swarmcensus.support.documents import json_value
from swarmcensus.support.formatting import ONE_SIDED, counted, decimals_for, fixed, rounded
from swarmcensus.support.intervals import FEWEST, LEVEL
from swarmcensus.support.printed_tables import ASKED, INTERVALS, NEVER, REST, Column, Table
from swarmcensus.support.quantities import QUANTITIES
from swarmcensus.support.toml_text import to_toml_value
from swarmcensus.worlds import MOVING

SHOWN = tuple(name for name, quantity in QUANTITIES.items() if quantity.shown)
MOST_DECIMALS = 6
DIGITS = {"convergence_round": 1, "agreement_round": 1}  # significant digits of an interval's width; 2 for others


class Summary(Answer):
    """The settings `shown` of results, a row each: medians over robots and trials, intervals over trials."""

    def __init__(
        self, stored: xr.Dataset, shown: xr.Dataset, checkpoint: int | None = None, path: Path | None = None,
        cautions: Sequence[str] = (), asked: str = "final_error", **parts: Any,
    ) -> None:  # fmt: skip
        """Summarise them, as of `checkpoint` (default: the last one); `asked` is the quantity that tables keep."""
        super().__init__(cautions=cautions, **parts)
        self.stored, self.shown, self.checkpoint, self.path, self.asked = stored, shown, checkpoint, path, asked

    @property
    def title(self) -> str:  # type: ignore[override]
        """The results file: its study, its settings and how many trials are done."""
        data = self.stored
        made = f"seed {data.attrs['seed']}, swarmcensus {data.attrs['swarmcensus_version']}"
        trials = f"{int(done_trials(data).sum()):,} of {counted(data.attrs['trials_total'], 'trial')} done"
        failed, settings = len(failed_trials(data)), counted(data.sizes["setting"], "setting")
        chosen = f"{self.shown.sizes['setting']:,} of " * (self.shown.sizes["setting"] < data.sizes["setting"])
        about = f"{data.attrs['title']} ({made}): {chosen}{settings}, {trials}"
        return f"{self.path}: " * bool(self.path) + about + f", {failed:,} failed" * (failed > 0)

    @functools.cached_property
    def rows(self) -> list[dict[str, Any]]:  # type: ignore[override]
        """The columns of `summary`, with brains' labels, and a word for swarms without members."""
        labels, rows = labels_in(self.shown), records(self.shown, self.checkpoint)
        named = [row | {"brain": labels.get(row["brain"], row["brain"])} for row in rows]
        return [row | {name: value_text(name, row[name]) for name in {"members"} & row.keys()} for row in named]

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """What JSON says of all settings, and of failed trials (see docs/data-format.md)."""
        stored, data = self.stored, self.shown
        return {
            "title": str(data.attrs["title"]),
            **{key: json_value(data.attrs[key]) for key in ("seed", "delta", "bins", "truth", "swarmcensus_version")},
            "rule": data["half_width"].attrs.get("rule") if "half_width" in data else None,
            "level": LEVEL,
            "settings_total": stored.sizes["setting"],
            "trials_done": int(done_trials(stored).sum()),
            "trials_total": int(stored.attrs["trials_total"]),
            "trials_failed": len(failed_trials(stored)),
            "failed": failed_trials(data),
        }

    def tables(self, limit: int) -> list[Table]:
        """One table."""
        data = self.shown
        frame = table_of(data.isel(setting=slice(limit or None)), self.checkpoint)
        varied, same = varied_and_same(data)
        columns = [Column("setting", frame["setting"].astype(str).tolist(), name="setting")]
        columns += [*coordinate_columns(varied, len(frame)), *_numbers(data, frame, self.asked)]
        one_sided = Table(columns).has_one_sided
        some = f"{len(frame):,} of {counted(data.sizes['setting'], 'setting')}"
        return [Table(
            columns, above=same, more=some * (len(frame) < data.sizes["setting"]),
            notes=lambda left_out: _notes(data, frame, left_out, one_sided),
        )]  # fmt: skip


def varied_and_same(data: xr.Dataset) -> tuple[dict[str, list[str]], list[str]]:
    """The coordinates that differ between settings, as text, and a line on those that do not, if there are any."""
    columns = coordinates(data)
    varied = {name: values.tolist() for name, values in columns.items() if (values != values[0]).any()}
    same = [f"{name} {values[0]}" for name, values in columns.items() if name not in varied and values[0] != EMPTY_CELL]
    return varied, [f"all with {', '.join(same)}"] * bool(same)


def coordinate_columns(varied: dict[str, list[str]], rows: int) -> list[Column]:
    """The columns of coordinates, of the first rows."""
    return [Column(name, values[:rows], number=False, name=name) for name, values in varied.items()]


def coordinates(data: xr.Dataset) -> dict[str, np.ndarray]:
    """The coordinates of settings as text, without those that another one implies and links that lose nothing."""
    along = {str(k): c.values for k, c in data.coords.items() if c.dims == ("setting",)}
    values_of = {name: values for name, values in along.items() if name not in ("setting", *NUMERIC)}
    columns = {name: np.array([value_text(name, value) for value in values]) for name, values in values_of.items()}
    labels = labels_in(data)
    columns["brain"] = np.array([labels.get(name, name) for name in columns["brain"].tolist()])
    if (columns["assumed_accuracy"] == columns["accuracy"]).all():
        del columns["assumed_accuracy"]
    for name, coordinate in COORDINATES.items():
        if coordinate.unsaid is not None and (data[name] == coordinate.unsaid).all():
            del columns[name]
    for name in repeated_coordinates(data):
        columns.pop(name, None)
    for name in dict.fromkeys(chain.from_iterable(parameters_in(data).values())):
        same = len({*columns[name]} - {"-"}) == 1 and "-" in columns[name]  # for all brains that have it
        if same or not is_set(data, name):
            del columns[name]
    return columns


def _numbers(data: xr.Dataset, frame: Any, asked: str) -> list[Column]:
    """The columns of numbers of a summary."""
    known = dict.fromkeys([*SHOWN, *metrics_in(data), *[asked] * (asked in QUANTITIES)])
    unshown = "" if asked == TAIL_QUANTITY or shows_tail(data) else TAIL_QUANTITY
    names = [name for name in known if name in frame and name != unshown]
    columns = [_values(data, frame, name, ASKED if name in (asked, "reached") else REST) for name in names]
    for name in ("consensus_right", "done"):
        if name in frame:
            cells = [EMPTY_CELL if np.isnan(share) else f"{100.0 * share:.1f}" for share in frame[name]]
            columns.append(Column(_head(data, name), cells, rank=REST, name=name, **measures.about(data, name)))
    some_lack = "half_width" in frame or (frame["trials"] < data.sizes["trial"]).any()
    for name in (name for name, is_told in (("trials", some_lack), ("failed", frame["failed"].any())) if is_told):
        columns.append(Column(name, [f"{n:,}" for n in frame[name]], rank=REST, name=name))
    if "half_width" in frame:
        decimals = decimals_for(frame["half_width"].min())
        cells = ["-" if np.isnan(width) else f"{width:.{decimals}f}" for width in frame["half_width"]]
        columns.append(Column(_head(data, "half_width"), cells, rank=REST, name="half_width"))
    return columns


def _head(data: xr.Dataset, name: str) -> str:
    return measures.head_of(data, name) + " %" * measures.is_share(name)


def _values(data: xr.Dataset, frame: Any, name: str, rank: int) -> Column:
    """A column of values with their intervals."""
    times, digits, known = 100.0 if measures.is_share(name) else 1.0, DIGITS.get(name, 2), QUANTITIES.get(name)
    ends = [times * frame.get(name + end, frame[name] * np.nan) for end in ("", "_low", "_high")]
    widths = (ends[2] - ends[1]).where(np.isfinite(ends[2]))
    usual = max(decimals_for(widths.median(), digits), int(times > 1.0))  # more for a narrow interval
    if known is None:  # values of a metric may be whole, infinite, or equal up to rounding
        finite = ends[0][np.isfinite(ends[0])]
        usual = 0 if widths.isna().all() and (finite == finite.round()).all() else min(usual, MOST_DECIMALS)
    texts = []
    for value, low, high in zip(*ends, strict=True):
        if np.isnan(low):
            text = f"{value:,.5g}" if known is None else fixed(value, known.decimals or 0)
            texts.append(("-" if np.isnan(value) else text, ""))
        else:
            finest = min(decimals_for(high - low, digits) - 1, MOST_DECIMALS) if np.isfinite(high - low) else 0
            texts.append(rounded(value, low, high, max(usual, finest), 100.0 if times > 1.0 else np.inf))
    if known is not None and known.never:
        texts = [(value.replace("inf", NEVER), ends.replace("inf", NEVER) * (value != "inf")) for value, ends in texts]
    values, intervals = map(list, zip(*texts, strict=True))
    return Column(_head(data, name), values, rank=rank, intervals=intervals, name=name, **measures.about(data, name))


def _notes(data: xr.Dataset, frame: Any, left_out: Collection[str], one_sided: bool) -> list[str]:
    """What values are, what intervals are of, and what else is to be known of these settings."""
    rounds = {round_ for round_ in frame["checkpoint"] if round_ >= 0}
    unit = "tick" if (data["topology"].values == MOVING).all() else "round"
    known, intervals = frame["convergence_round_low"].notna().any(), INTERVALS not in left_out
    with_names = dict.fromkeys(data["brain"].values[data["anonymous"].values == 0].tolist())  # of their robots
    rule = f"+-: of the rule {data['half_width'].attrs['rule']}" if "half_width" in data else ""
    notes = {
        f"values: medians, {pooled_in_rows(data)}; shares: means": True,
        f"right: after {unit} {min(rounds, default=0):,}": len(rounds) == 1 and _head(data, "correct") not in left_out,
        "[95 %]: over trials": known and intervals,
        f"no intervals: fewer than {FEWEST:,} trials": not known,
        f"[>= x]: {ONE_SIDED}": intervals and one_sided,
        f"agreement round 0: {AGREED_AT_START}": bool((frame.get("agreement_round", np.zeros(0)) == 0).any()),
        "f: the black share of the trial's own floor": data.attrs["truth"] == "floor",
        f"{rule}: wider than those above, because the rule is checked repeatedly": bool(rule),
        "robots that are not honest are left out": "honest" in data,
        f"not anonymous: {', '.join(with_names)}": bool(with_names),
    }
    said = "; ".join(note for note, applies in notes.items() if applies)
    faults = [f"fault {to_toml_value(fault)}" for study in studies_in(data) for fault in study.get("faults", [])]
    liars = sorted({name for name in data["adversary"].values.tolist() if name}) if "adversary" in data.coords else []
    adversaries = [f"adversaries among the robots: {', '.join(liars)}"] if liars else []
    return [said, *dict.fromkeys(faults), *adversaries]


def pooled_in_rows(data: xr.Dataset) -> str:
    """What each row of `show` is pooled over."""
    trials, robots = done_trials(data).sum(axis=1), robots_in(data).values
    spans = []
    for numbers, noun in ((trials, "trial"), (robots, "robot")):
        low, high = int(numbers.min()), int(numbers.max())
        spans.append(f"{low:,} to " * (low < high) + counted(high, noun))
    return f"pooled over {' of '.join(spans)}"
