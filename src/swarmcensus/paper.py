"""The paper's evaluation from one call: its studies run, its figures drawn, its claims checked, a page of it all.

Chin, Khaluf and Pinciroli, "Minimalistic Collective Perception with Imperfect Sensors", Sec. IV. To add a part of
the evaluation, add study files to studies/paper, figures to FIGURES and claims to `claims.CLAIMS`.
"""

import contextlib
import shlex
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import xarray as xr

from swarmcensus import claims, page, report, results
from swarmcensus.errors import InputError, Interrupted
from swarmcensus.evidence import Outcome
from swarmcensus.files import check_writable, whole
from swarmcensus.running import Progress, plan, run
from swarmcensus.studies import Study

Reporting = Callable[[str], AbstractContextManager[Callable[[Progress], None]]]


@dataclass(frozen=True)
class View:
    """One panel of a figure: the settings of `study` that have the coordinates `where`."""

    caption: str
    study: str
    where: Mapping[str, object]
    local: bool = False

    def panel(self, datasets: Mapping[str, xr.Dataset]) -> tuple[str, xr.Dataset, bool]:
        """The panel as the drawing functions take it."""
        data = datasets[self.study]
        mask = np.logical_and.reduce([data[name].values == value for name, value in self.where.items()])
        return self.caption, data.isel(setting=np.flatnonzero(mask)), self.local


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper: its panels, what is to be seen in it, and the claims that speak of it."""

    name: str
    title: str
    kind: str  # "scatter" or "decisions"
    views: tuple[View, ...]
    text: str
    claims: tuple[str, ...]


@dataclass(frozen=True)
class Reproduction:
    """What `reproduce` has made: outcomes of claims, paths of all files, seconds by stage, and what it came from."""

    out: Path
    command: str
    datasets: dict[str, xr.Dataset] = field(default_factory=dict)
    figures: list[tuple[PaperFigure, list[Path]]] = field(default_factory=list)
    claims: list[Outcome] = field(default_factory=list)
    paths: list[Path] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)

    @property
    def page(self) -> Path:
        """The page to open in a browser."""
        return self.out / "index.html"


def _view(caption: str, topology: str, fill: float, study: str = "topologies") -> View:
    return View(caption, study, {"topology": topology, "robots": 100, "fill_ratio": fill})


_DOTS = (
    "Every faint dot is one robot in one trial: to the right the time until its estimate settled, upwards how wrong "
    "the estimate then was. The solid, outlined dots are medians, a colour for each sensor accuracy, black for the "
    "heterogeneous swarm. Best is bottom left. "
)

FIGURES: tuple[PaperFigure, ...] = (
    PaperFigure(
        "fig2", "Fig. 2: alone and together, 100 robots, f = 0.55", "scatter",
        (
            View("local estimates, no communication", "local", {"robots": 100, "fill_ratio": 0.55}, local=True),
            _view("fully connected", "full", 0.55),
            _view("ring", "ring", 0.55),
            _view("scale-free", "scale-free", 0.55),
        ),
        _DOTS + "Panel (a) counts single observations, 10,000 in all; (b) to (d) count communication rounds of 10 "
        "observations each. Look for three things: medians move down and left as sensors get better; (b) to (d) lie "
        "below (a), most of all for poor sensors; and fully connected robots settle many times sooner than "
        "the ring or the scale-free tree, which look alike. The paper shows the same four panels.",
        ("low-error-055", "full-agrees", "full-first", "ring-like-line", "informed-first", "helps-poor", "grows",
         "mixed-055"),
    ),
    PaperFigure(
        "fig3", "Fig. 3: a blacker floor, and talking too early; 100 robots, scale-free", "scatter",
        (
            _view("f = 0.95, R = 10", "scale-free", 0.95),
            _view("f = 0.55, R = 1", "scale-free", 0.55, "same-rounds"),
        ),
        _DOTS + "Panel (a) is Fig. 2 (d) on a floor that is nearly all black: the good sensors lie further "
        "left, and a streak at errors of 0.04 to 0.05 holds poor sensors whose estimates are cut off at 1. In panel (b) "
        "robots talk after every observation, and so have made a tenth of the observations by "
        "the last round: all lie further right, and errors reach higher. The paper shows the same two panels.",
        ("low-error-095", "mixed-095", "blacker-first-sparse", "blacker-first-full", "same-observations",
         "same-rounds"),
    ),
    PaperFigure(
        "fig4", "Fig. 4: how many robots decide rightly; 100 robots, scale-free", "decisions",
        (_view("f = 0.55", "scale-free", 0.55), _view("f = 0.95", "scale-free", 0.95)),
        "If the swarm were asked after so many communication rounds: the share of robots, over all trials, that pick "
        "the right one of ten bins. A diamond for each sensor accuracy, side by side; the bar through a diamond says "
        "that not one robot of any trial was wrong. All accuracies climb to the top but the two poorest. The heterogeneous "
        "swarm gets close to it: the few robots that stay wrong have a sensor below 0.6 and a single neighbour that has "
        "such a one too. "
        "These are panels (a) and (b) of the paper's figure; (c) and (d) show moving robots.",
        ("consensus", "sooner-right"),
    ),
)  # fmt: skip
PARTS = (*(figure.name for figure in FIGURES), "claims")


def studies_folder() -> Path:
    """Where the paper's study files are, installed or in a source checkout. Raises InputError."""
    here = Path(__file__).parent
    for folder in (here / "paper_studies", here.parents[1] / "studies" / "paper"):
        if folder.is_dir():
            return folder
    raise InputError(f"the paper's study files are missing: this installation has no folder {here / 'paper_studies'}")


def reproduce(
    out: str | Path = "reproduction",
    *,
    trials: int | None = None,
    seed: int | None = None,
    jobs: int | None = None,
    only: str | Iterable[str] | None = None,
    reporting: Reporting | None = None,
    say: Callable[[str], None] = print,
) -> Reproduction:
    """Run what the paper ran, and write datasets, figures, claims.json and index.html to the folder `out`.

    `trials` and `seed` replace those of the study files. `only` names parts (PARTS) and runs nothing that they do
    not need. `reporting(label)` is a context that gives the callback for `run`'s progress, here of all studies
    together; `say` gets a line a stage.

    Raises InputError for an unknown part and, before anything is run, for a folder that cannot be written. Ctrl-C
    raises Interrupted; finished studies are then in `out`, and what was done of the others as NAME.partial.nc.
    """
    parts = _parts(only)
    out = Path(out)
    figures = [figure for figure in FIGURES if figure.name in parts]
    checked = claims.CLAIMS if "claims" in parts else ()
    needed = {view.study for figure in figures for view in figure.views} | {s for c in checked for s in c.studies}
    files = sorted(studies_folder().glob("*.toml"))
    studies = {p.stem: Study.load(p).with_(trials=trials, seed=seed) for p in files if p.stem in needed}
    for path in (
        "index.html",
        "claims.json",
        *(f"data/{n}.nc" for n in studies),
        *(f"figures/{f.name}.png" for f in figures),
    ):
        check_writable(out / path)
    command = ["swarmcensus", "reproduce", "--out", str(out)]
    command += [word for k, v in (("--trials", trials), ("--seed", seed)) if v is not None for word in (k, str(v))]
    done = Reproduction(out, shlex.join(command + (["--only", *parts] if only is not None else [])))

    with _timed(done, "simulate", say):
        _simulate(done, studies, jobs, reporting or (lambda _: contextlib.nullcontext(lambda _: None)))
    if figures:
        with _timed(done, "figures", say):
            _draw(done, figures)
    if checked:
        with _timed(done, "claims", say):
            done.claims.extend(claims.check(done.datasets, checked))
            _write(done, out / "claims.json", report.as_json(done.claims, done.datasets))
    with _timed(done, "page", say):
        _write(done, done.page, page.html(done))
    return done


def _parts(only: str | Iterable[str] | None) -> list[str]:
    parts = PARTS if only is None else [only] if isinstance(only, str) else list(only)
    for part in parts:
        if part not in PARTS:
            raise InputError(f"there is no part {part!r} of the paper: known are {', '.join(PARTS)}")
    return [part for part in PARTS if part in parts]


@contextlib.contextmanager
def _timed(done: Reproduction, stage: str, say: Callable[[str], None]) -> Iterator[None]:
    begun, files = time.perf_counter(), len(done.paths)
    yield
    done.seconds[stage] = round(time.perf_counter() - begun, 3)
    made = ", ".join(path.relative_to(done.out).as_posix() for path in done.paths[files:])
    say(f"{stage}: {done.seconds[stage]:.1f} s  ({made})")


def _simulate(done: Reproduction, studies: Mapping[str, Study], jobs: int | None, reporting: Reporting) -> None:
    sizes = {}
    for name, study in studies.items():
        settings = study.settings()
        sizes[name] = study.trials * len(settings), sum(task.cost for task in plan(study, settings))
    trials, work = map(sum, zip(*sizes.values(), strict=True)) if sizes else (0, 0.0)
    trials_before, work_before = 0, 0.0
    with reporting("reproduce") as progress:
        for name, study in studies.items():

            def show(p: Progress, trials_before: int = trials_before, work_before: float = work_before) -> None:
                progress(Progress(trials_before + p.done, int(trials), work_before + p.work_done, work))

            path = done.out / "data" / f"{name}.nc"
            partial = path.with_suffix(".partial.nc")
            try:
                data = run(study, jobs=jobs, progress=show)
            except Interrupted as stopped:
                if stopped.done and isinstance(stopped.results, xr.Dataset):
                    results.save(stopped.results, partial)
                raise
            results.save(data, path)
            partial.unlink(missing_ok=True)
            done.datasets[name] = data
            done.paths.append(path)
            trials_before += sizes[name][0]
            work_before += sizes[name][1]


def _draw(done: Reproduction, figures: Iterable[PaperFigure]) -> None:
    from swarmcensus import figures as draw  # matplotlib: half a second, and not every part needs it

    for figure in figures:
        kind = draw.scatter_grid if figure.kind == "scatter" else draw.decisions_grid
        sheet = kind([view.panel(done.datasets) for view in figure.views])
        paths = draw.save(sheet, done.out / "figures" / figure.name, ("png", "svg"))
        done.figures.append((figure, paths))
        done.paths.extend(paths)


def _write(done: Reproduction, path: Path, text: str) -> None:
    with whole(path) as beside:
        beside.write_text(text, encoding="utf-8")
    done.paths.append(path)
