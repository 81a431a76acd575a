"""`reproduce`: run the studies of an evaluation, draw its figures, check its claims and write a page.

To add a part of the paper's evaluation, add study files to studies/paper, and figures and claims to paper.toml. The
claims on rivals are in rivals.toml, and their studies in studies/rivals/claims.
"""

import contextlib
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import xarray as xr

from swarmcensus.evaluation.paper import page, report
from swarmcensus.evaluation.paper.evaluations import PAPER, Evaluation, PaperFigure, evaluation
from swarmcensus.evaluation.paper.evidence import check
from swarmcensus.evaluation.paper.page import AS_PAPER
from swarmcensus.evaluation.paper.report import Reproduction
from swarmcensus.runs import Device, Hardware, Progress, Report, compile_for, placing_of, run, showing
from swarmcensus.studies import Study
from swarmcensus.support.errors import InputError
from swarmcensus.support.files import atomic_write, check_own, check_writable, data_path, shipped_study
from swarmcensus.support.fork import in_background
from swarmcensus.support.formatting import elapsed
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import command

STUDIES = {"rivals": "rivals/claims"}  # folders of studies, where they differ from the name
TAKEN_OVER = 0.05  # seconds simulated by earlier calls that are worth mentioning


def reproduce(
    out: str | Path | None = None, *, of: str = "paper", trials: int | None = None, seed: int | None = None,
    jobs: int | None = None, only: str | Iterable[str] | None = None, fresh: bool = False, pdf: bool = False,
    progress: Report | bool = True, say: Callable[[str], None] = print, device: Device = "cpu",
) -> Reproduction:  # fmt: skip
    """Run an evaluation and check its claims; datasets, figures, claims.json and index.html go to the folder `out`.

    Without `out` nothing is written, and no figure is drawn. `of` is "paper", or "rivals" for published results on
    other algorithms. `trials` and `seed` replace those of the study files. `only` names parts, such as "fig2" or
    "claims", and runs only the studies that they need. With `pdf`, figures are also written as PDF. `device` is as
    for `run`, and so is `progress`, of all studies together; `say` gets one line per stage.

    Raises InputError for unknown names and, before anything is run, for a folder that cannot be written. Ctrl-C
    raises Interrupted; finished work is kept in `out`, and the same call continues from there, unless `fresh`.
    """
    this, out = evaluation(of), None if out is None else Path(out)
    parts = _parts(this, only)
    figures = [figure for figure in this.figures if figure.name in parts]
    checks = this.claims if "claims" in parts else ()
    needed = {view.study for figure in figures for view in figure.views}
    needed |= {study for claim in checks for study in claim.studies}
    files = [path for path in sorted(shipped_study(STUDIES.get(of, of)).glob("*.toml")) if path.stem in needed]
    studies = {path.stem: Study.load(path).with_(trials=trials, seed=seed) for path in files}
    formats = ("png", "svg", *(["pdf"] if pdf else []))
    if out is not None:
        stems = [out / "figures" / figure.name for figure in figures]
        names = [f"{figure.name}{end}" for figure in figures for end in ("", AS_PAPER)]
        pictures = [out / "figures" / f"{name}.{suffix}" for name in names for suffix in formats]
        check_own(out / "index.html", lambda text: f"<title>{this.title}</title>" in text, "reproduce")
        for path in [out / "claims.json", *(data_path(out, name) for name in studies), *pictures]:
            check_writable(path)

    seconds: dict[str, float] = {}

    def report_time(name: str, spent: float, more: str = "") -> None:
        seconds[name] = round(spent, 3)
        say(f"{name}: {elapsed(seconds[name])}{more}")

    @contextlib.contextmanager
    def stage(name: str) -> Iterator[None]:
        begun = time.monotonic()
        yield
        report_time(name, time.monotonic() - begun)

    datasets, compiled, simulated = _simulate(out, studies, Hardware(jobs, device), fresh, progress, say)
    if compiled:
        report_time("compile", compiled)
    if datasets:
        total = sum(data.attrs["wall_seconds"] for data in datasets.values())
        report_time("simulate", total, ", with earlier calls" if total - simulated > TAKEN_OVER else "")
    drawn, outcomes = [], []
    if figures and out is not None:
        with stage("figures"):
            drawn = list(zip(figures, _drawn(figures, datasets, stems, formats), strict=True))
    if checks:
        with stage("claims"):
            outcomes = check(datasets, checks)
            if out is not None:
                _write(out / "claims.json", report.as_json(outcomes, datasets, this.source))
    done = Reproduction(out, _command(this, out, trials, seed, parts), datasets, drawn, outcomes, seconds, this)
    if done.page is not None:
        with stage("page"):
            _write(done.page, page.html(done))
    return done


def _parts(this: Evaluation, only: str | Iterable[str] | None) -> list[str]:
    chosen = [only] if isinstance(only, str) else list(only or this.parts)
    for part in chosen:
        if part not in this.parts:
            hint, known = did_you_mean(part, this.parts), ", ".join(this.parts)
            if part in ("paper", "rivals"):
                hint = f"did you mean '{command('swarmcensus', 'reproduce', part)}'? "
            why = f"there is no part {part!r} of the {this.name}: {hint}known are {known}"
            raise InputError(why, key="only", value=part)
    return [part for part in this.parts if part in chosen]


def _command(this: Evaluation, out: Path | None, trials: int | None, seed: int | None, parts: list[str]) -> str:
    words = ["swarmcensus", "reproduce", *([this.name] if this is not PAPER else [])]
    for option, value in (("--out", out), ("--trials", trials), ("--seed", seed)):
        words += [option, str(value)] if value is not None else []
    return command(*words, *(["--only", *parts] if len(parts) < len(this.parts) else []))


def _simulate(
    out: Path | None, studies: Mapping[str, Study], hardware: Hardware, fresh: bool, progress: Report | bool,
    say: Callable[[str], None],
) -> tuple[dict[str, xr.Dataset], float, float]:  # fmt: skip
    """The results of all studies, and the seconds that this call compiled and simulated."""
    files = {name: None if out is None else data_path(out, name) for name in studies}
    datasets: dict[str, xr.Dataset] = {}
    begun = compiled = time.monotonic()
    with showing(progress, "reproduce") as report:
        # for all studies at once, so that two compile at a time
        if fresh or not all(path is not None and path.exists() for path in files.values()):
            every = ((one, one.settings()) for one in studies.values())
            needed = [(one, placing_of(hardware, one, ours, one.trials).on_cpu(ours)) for one, ours in every]
            compile_for(needed, lambda note: report(Progress(0, 0, 0.0, 0.0, note)))
            compiled = time.monotonic()
        for name, study in studies.items():

            def show(now: Progress, stage: str = f"{len(datasets) + 1} of {len(studies)}, {name}") -> None:
                report(replace(now, stage=stage, part="this study"))

            datasets[name] = run(
                study, progress=show, out=files[name], fresh=fresh, say=say, cautions=False, **vars(hardware)
            )
    return datasets, compiled - begun, time.monotonic() - compiled


def _drawn(
    figures: Sequence[PaperFigure], datasets: Mapping[str, xr.Dataset], stems: Sequence[Path], formats: Sequence[str]
) -> list[list[Path]]:
    """Draw all figures, every second one in a copy of this process. Returns the files of each."""
    from swarmcensus.figures import columns_grid, save  # imports matplotlib: half a second, which not every part needs
    from swarmcensus.figures.kinds.scatter import scatter_grid

    def draw(figure: PaperFigure, stem: Path) -> list[Path]:
        paths = []
        for as_paper in (False, True):
            panels = [view.panel(datasets, as_paper=as_paper) for view in figure.views]
            if figure.kind == "scatter":
                drawn = scatter_grid(panels, scale="linear" if as_paper else figure.scale, claimed=figure.claimed)
            else:
                drawn = columns_grid(panels, claimed=figure.claimed, as_paper=as_paper)
            place = stem.with_name(stem.name + AS_PAPER) if as_paper else stem
            paths += save(drawn, place, formats, captioned=False)
        return paths

    tasks = list(zip(figures, stems, strict=True))
    others = in_background(lambda: [draw(*task) for task in tasks[1::2]])
    files: list[list[Path]] = [[]] * len(tasks)
    files[::2] = [draw(*task) for task in tasks[::2]]
    files[1::2] = others()
    return files


def _write(path: Path, text: str) -> None:
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
