"""The paper's evaluation from one call: its studies run, its figures drawn, its claims checked, a page of it all.

Chin, Khaluf and Pinciroli, "Minimalistic Collective Perception with Imperfect Sensors", Sec. IV. To add a part of
the evaluation, add study files to studies/paper, figures to `paper_figures.FIGURES` and claims to `claims.CLAIMS`.
"""

import contextlib
import shlex
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

import xarray as xr

from swarmcensus import claims, page, report
from swarmcensus.errors import InputError
from swarmcensus.evidence import Outcome
from swarmcensus.files import check_writable, whole
from swarmcensus.hints import did_you_mean
from swarmcensus.paper_figures import FIGURES, PaperFigure
from swarmcensus.running import Progress, run, work_of
from swarmcensus.studies import Study

Reporting = Callable[[str], AbstractContextManager[Callable[[Progress], None]]]


@dataclass(frozen=True)
class Reproduction:
    """What `reproduce` made: datasets by study, figures with their files, claims as measured, seconds by stage.

    Those of "simulate" are of all runs on these datasets together; the other stages are done anew each time.
    """

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


TAKEN_OVER = 0.05  # seconds: from there on it shows that simulations are not all of this call
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
    fresh: bool = False,
    reporting: Reporting | None = None,
    say: Callable[[str], None] = print,
) -> Reproduction:
    """Run what the paper ran, and write datasets, figures, claims.json and index.html to the folder `out`.

    `trials` and `seed` replace those of the study files. `only` names parts (PARTS) and runs nothing that they do
    not need. `reporting(label)` is a context that gives the callback for `run`'s progress, here of all studies
    together; `say` gets a line a stage.

    Raises InputError for an unknown part and, before anything is run, for a folder that cannot be written. Ctrl-C
    raises Interrupted; what was done is then in `out`, and the same call goes on from there, unless `fresh`.
    """
    parts, out = _parts(only), Path(out)
    figures = [figure for figure in FIGURES if figure.name in parts]
    checks = claims.CLAIMS if "claims" in parts else ()
    needed = {view.study for figure in figures for view in figure.views}
    needed |= {study for claim in checks for study in claim.studies}
    files = [path for path in sorted(studies_folder().glob("*.toml")) if path.stem in needed]
    studies = {path.stem: Study.load(path).with_(trials=trials, seed=seed) for path in files}
    stems = [out / "figures" / figure.name for figure in figures]
    _check_own(out / "index.html")
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

    begun = time.perf_counter()
    datasets = _simulate(out, studies, jobs, fresh, reporting, say)
    spent = time.perf_counter() - begun
    seconds["simulate"] = round(sum(data.attrs["wall_seconds"] for data in datasets.values()), 3)
    more = f" now, {seconds['simulate']:.1f} s in all" if datasets and seconds["simulate"] - spent > TAKEN_OVER else ""
    say(f"simulate: {spent:.1f} s{more}")
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
            raise InputError(
                f"there is no part {part!r} of the paper: {did_you_mean(part, PARTS)}known are {', '.join(PARTS)}"
            )
    return [part for part in PARTS if part in asked]


def _check_own(path: Path) -> None:
    """Raise InputError where a page cannot be written, or is somebody else's."""
    check_writable(path)
    if path.exists() and f"<title>{page.TITLE}</title>" not in path.read_text(encoding="utf-8", errors="replace"):
        raise InputError(f"{path} is there, and no page of reproduce: write to another folder with --out")


def _command(out: Path, trials: int | None, seed: int | None, parts: list[str]) -> str:
    words = ["swarmcensus", "reproduce", "--out", str(out)]
    for option, value in (("--trials", trials), ("--seed", seed)):
        words += [option, str(value)] if value is not None else []
    return shlex.join(words + (["--only", *parts] if len(parts) < len(PARTS) else []))


def _simulate(
    out: Path,
    studies: Mapping[str, Study],
    jobs: int | None,
    fresh: bool,
    reporting: Reporting | None,
    say: Callable[[str], None],
) -> dict[str, xr.Dataset]:
    settings = {name: study.settings() for name, study in studies.items()}
    trials = {name: study.trials * len(settings[name]) for name, study in studies.items()}
    work = {name: work_of(study, settings[name]) for name, study in studies.items()}
    datasets: dict[str, xr.Dataset] = {}
    with reporting("reproduce") if reporting else contextlib.nullcontext() as progress:

        def show(now: Progress) -> None:
            if progress:
                before, work_before = (sum(each[name] for name in datasets) for each in (trials, work))
                total, work_total = sum(trials.values()), sum(work.values())
                progress(Progress(int(before) + now.done, total, work_before + now.work_done, work_total, now.note))

        for name, study in studies.items():
            datasets[name] = run(study, jobs=jobs, progress=show, out=data_path(out, name), fresh=fresh, say=say)
    return datasets


def _draw(figure: PaperFigure, datasets: Mapping[str, xr.Dataset], stem: Path) -> list[Path]:
    from swarmcensus import figures  # matplotlib: half a second, and not every part needs it

    panels = [view.panel(datasets) for view in figure.views]
    scatter = figure.kind == "scatter"
    drawn = figures.scatter_grid(panels, scale=figure.scale) if scatter else figures.decisions_grid(panels)
    return figures.save(drawn, stem, ("png", "svg"))


def _write(path: Path, text: str) -> None:
    with whole(path) as beside:
        beside.write_text(text, encoding="utf-8")
