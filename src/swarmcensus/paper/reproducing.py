"""The paper's evaluation from one call: its studies run, its figures drawn, its claims checked, a page of it all.

Chin, Khaluf and Pinciroli, "Minimalistic Collective Perception with Imperfect Sensors", Sec. IV. To add a part of
the evaluation, add study files to studies/paper, figures to `paper_figures.FIGURES` and claims to `claims.CLAIMS`.
"""

import contextlib
import shlex
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path

import xarray as xr

from swarmcensus.basics.copies import beside
from swarmcensus.basics.errors import InputError
from swarmcensus.basics.files import check_writable, whole
from swarmcensus.basics.hints import did_you_mean
from swarmcensus.paper import claims, page, report
from swarmcensus.paper.figures import FIGURES, PaperFigure
from swarmcensus.paper.page import Reproduction, data_path
from swarmcensus.runs.pools import compile_for
from swarmcensus.runs.running import run, work_of
from swarmcensus.runs.working import Progress
from swarmcensus.studies.study import Study

Reporting = Callable[[str], AbstractContextManager[Callable[[Progress], None]]]


TAKEN_OVER = 0.05  # seconds: from there on it shows that simulations are not all of this call
PARTS = (*(figure.name for figure in FIGURES), "claims")


def studies_folder() -> Path:
    """Where the paper's study files are, installed or in a source checkout. Raises InputError."""
    here = Path(__file__).parents[1]
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
            drawn = list(zip(figures, _drawn(figures, datasets, stems), strict=True))
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
    if any(not data_path(out, name).exists() for name in studies):  # of all studies at a time, as two can be compiled
        compile_for([(study, settings[name]) for name, study in studies.items()], say)
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


def _drawn(
    figures: Sequence[PaperFigure], datasets: Mapping[str, xr.Dataset], stems: Sequence[Path]
) -> list[list[Path]]:
    """Draw all figures, every other one in a copy of this process, and return the files of each."""
    from swarmcensus.figures.files import save  # matplotlib: half a second, and not every part needs it
    from swarmcensus.figures.kinds.decisions import decisions_grid
    from swarmcensus.figures.kinds.scatter import scatter_grid

    def draw(figure: PaperFigure, stem: Path) -> list[Path]:
        panels = [view.panel(datasets) for view in figure.views]
        scatter = figure.kind == "scatter"
        drawn = scatter_grid(panels, scale=figure.scale) if scatter else decisions_grid(panels)
        return save(drawn, stem)

    asked = list(zip(figures, stems, strict=True))
    others = beside(lambda: [draw(*one) for one in asked[1::2]])
    done: list[list[Path]] = [[]] * len(asked)
    done[::2] = [draw(*one) for one in asked[::2]]
    done[1::2] = others()
    return done


def _write(path: Path, text: str) -> None:
    with whole(path) as beside:
        beside.write_text(text, encoding="utf-8")
