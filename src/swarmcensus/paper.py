"""The paper's evaluation from one call: its studies run, its figures drawn, its claims checked, a page of it all.

Chin, Khaluf and Pinciroli, "Minimalistic Collective Perception with Imperfect Sensors", Sec. IV. To add a part of
the evaluation, add study files to studies/paper, figures to FIGURES and claims to `claims.CLAIMS`.
"""

import contextlib
import shlex
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
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
    """What `reproduce` made: datasets by study, figures with their files, claims as measured, seconds by stage."""

    out: Path
    command: str
    datasets: Mapping[str, xr.Dataset]
    figures: Sequence[tuple[PaperFigure, Sequence[Path]]]
    claims: Sequence[Outcome]
    seconds: Mapping[str, float]

    @property
    def page(self) -> Path:
        """The page to open in a browser."""
        return self.out / "index.html"

    @property
    def files(self) -> list[Path]:
        """All other files that were written."""
        data = [data_path(self.out, name) for name in self.datasets]
        drawn = [path for _, paths in self.figures for path in paths]
        return [*data, *drawn, *([self.out / "claims.json"] if self.claims else [])]


def _view(caption: str, topology: str, fill: float, study: str = "topologies") -> View:
    return View(caption, study, {"topology": topology, "robots": 100, "fill_ratio": fill})


_DOTS = (
    "Every faint dot is one robot in one trial: to the right the time until its estimate settled, upwards how wrong it "
    "then was. The solid, outlined dots are medians, a colour for each sensor accuracy, black for the heterogeneous "
    "swarm. Best is bottom left. "
)

FIGURES: tuple[PaperFigure, ...] = (
    PaperFigure(
        name="fig2",
        title="Fig. 2: alone and together, 100 robots, f = 0.55",
        kind="scatter",
        views=(
            View("local estimates, no communication", "local", {"robots": 100, "fill_ratio": 0.55}, local=True),
            _view("fully connected", "full", 0.55),
            _view("ring", "ring", 0.55),
            _view("scale-free", "scale-free", 0.55),
        ),
        text=_DOTS + "Panel (a) counts single observations, 10,000 in all; (b) to (d) count communication rounds of 10 "
        "observations each. Look for three things: medians move down and left as sensors get better; those of poor "
        "sensors lie much higher in (a) than in the other panels; and fully connected robots settle many times sooner "
        "than those on the ring and on the scale-free tree, which look alike. The paper shows the same four panels.",
        claims=(
            *("low-error-055", "full-agrees", "full-first", "ring-like-line", "informed-first", "helps-poor"),
            *("grows", "mixed-055"),
        ),
    ),
    PaperFigure(
        name="fig3",
        title="Fig. 3: a blacker floor, and talking too early; 100 robots, scale-free",
        kind="scatter",
        views=(
            _view("f = 0.95, R = 10", "scale-free", 0.95),
            _view("f = 0.55, R = 1", "scale-free", 0.55, "same-rounds"),
        ),
        text=_DOTS + "Panel (a) is Fig. 2 (d) on a floor that is nearly all black: the good sensors lie further left, "
        "and a streak at errors of 0.04 to 0.05 holds poor sensors whose estimates are cut off at 1. In panel (b) "
        "robots talk after every observation, and so have made a tenth of the observations by the last round: all "
        "lie further right, and errors reach higher. The paper shows the same two panels.",
        claims=(
            *("low-error-095", "mixed-095", "blacker-first-sparse", "blacker-first-full"),
            *("same-observations", "same-rounds"),
        ),
    ),
    PaperFigure(
        name="fig4",
        title="Fig. 4: how many robots decide rightly; 100 robots, scale-free",
        kind="decisions",
        views=(_view("f = 0.55", "scale-free", 0.55), _view("f = 0.95", "scale-free", 0.95)),
        text="If the swarm were asked after so many communication rounds: the share of robots, over all trials, that "
        "pick the right one of ten bins. A diamond for each sensor accuracy, side by side; the bar through a diamond "
        "says that not one robot of any trial was wrong. All accuracies climb to the top but the two poorest. The "
        "heterogeneous swarm gets close to it: the few robots that stay wrong have a poor sensor, and a single "
        "neighbour that has one too. The paper's panels (a) and (b); its (c) and (d) show moving robots.",
        claims=("consensus", "sooner-right"),
    ),
)
PARTS = (*(figure.name for figure in FIGURES), "claims")


def studies_folder() -> Path:
    """Where the paper's study files are, installed or in a source checkout. Raises InputError."""
    here = Path(__file__).parent
    for folder in (here / "paper_studies", here.parents[1] / "studies" / "paper"):
        if folder.is_dir():
            return folder
    raise InputError(f"the paper's study files are missing: this installation has no folder {here / 'paper_studies'}")


def data_path(out: Path, study: str) -> Path:
    """Where the dataset of a study goes."""
    return out / "data" / f"{study}.nc"


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
    raises Interrupted; finished studies are then in `out`, and what was done of the next as NAME.partial.nc.
    """
    parts, out = _parts(only), Path(out)
    figures = [figure for figure in FIGURES if figure.name in parts]
    checks = claims.CLAIMS if "claims" in parts else ()
    needed = {view.study for figure in figures for view in figure.views}
    needed |= {study for claim in checks for study in claim.studies}
    files = [path for path in sorted(studies_folder().glob("*.toml")) if path.stem in needed]
    studies = {path.stem: Study.load(path).with_(trials=trials, seed=seed) for path in files}
    stems = [out / "figures" / figure.name for figure in figures]
    check_writable(out / "index.html")
    check_writable(out / "claims.json")
    for path in [data_path(out, name) for name in studies] + [stem.with_suffix(".png") for stem in stems]:
        check_writable(path)

    seconds: dict[str, float] = {}

    @contextlib.contextmanager
    def stage(name: str) -> Iterator[None]:
        begun = time.perf_counter()
        yield
        seconds[name] = round(time.perf_counter() - begun, 3)
        say(f"{name}: {seconds[name]:.1f} s")

    with stage("simulate"):
        datasets = _simulate(out, studies, jobs, reporting)
    drawn, outcomes = [], []
    if figures:
        with stage("figures"):
            drawn = [(figure, _draw(figure, datasets, stem)) for figure, stem in zip(figures, stems, strict=True)]
    if checks:
        with stage("claims"):
            outcomes = claims.check(datasets, checks)
            _write(out / "claims.json", report.as_json(outcomes, datasets))
    done = Reproduction(out, _command(out, trials, seed, parts), datasets, drawn, outcomes, seconds)
    with stage("page"):
        _write(done.page, page.html(done))
    return done


def _parts(only: str | Iterable[str] | None) -> list[str]:
    asked = [only] if isinstance(only, str) else list(only or PARTS)
    for part in asked:
        if part not in PARTS:
            raise InputError(f"there is no part {part!r} of the paper: known are {', '.join(PARTS)}")
    return [part for part in PARTS if part in asked]


def _command(out: Path, trials: int | None, seed: int | None, parts: list[str]) -> str:
    words = ["swarmcensus", "reproduce", "--out", str(out)]
    for option, value in (("--trials", trials), ("--seed", seed)):
        words += [option, str(value)] if value is not None else []
    return shlex.join(words + (["--only", *parts] if len(parts) < len(PARTS) else []))


def _simulate(
    out: Path, studies: Mapping[str, Study], jobs: int | None, reporting: Reporting | None
) -> dict[str, xr.Dataset]:
    settings = {name: study.settings() for name, study in studies.items()}
    trials = {name: study.trials * len(settings[name]) for name, study in studies.items()}
    work = {name: sum(task.cost for task in plan(study, settings[name])) for name, study in studies.items()}
    datasets: dict[str, xr.Dataset] = {}
    with reporting("reproduce") if reporting else contextlib.nullcontext() as progress:

        def show(now: Progress) -> None:
            if progress:
                before, work_before = (sum(each[name] for name in datasets) for each in (trials, work))
                total, work_total = sum(trials.values()), sum(work.values())
                progress(Progress(int(before) + now.done, total, work_before + now.work_done, work_total))

        for name, study in studies.items():
            path = data_path(out, name)
            partial = path.with_suffix(".partial.nc")
            try:
                data = run(study, jobs=jobs, progress=show)
            except Interrupted as stopped:
                if stopped.done and isinstance(stopped.results, xr.Dataset):
                    results.save(stopped.results, partial)
                raise
            results.save(data, path)
            partial.unlink(missing_ok=True)
            datasets[name] = data
    return datasets


def _draw(figure: PaperFigure, datasets: Mapping[str, xr.Dataset], stem: Path) -> list[Path]:
    from swarmcensus import figures  # matplotlib: half a second, and not every part needs it

    grid = figures.scatter_grid if figure.kind == "scatter" else figures.decisions_grid
    return figures.save(grid([view.panel(datasets) for view in figure.views]), stem, ("png", "svg"))


def _write(path: Path, text: str) -> None:
    with whole(path) as beside:
        beside.write_text(text, encoding="utf-8")
