"""A published evaluation from one call: its studies run, its figures drawn, its claims checked, a page of it all.

To add a part of the paper's evaluation, add study files to studies/paper, figures to `figures.FIGURES` and claims to
`claims.CLAIMS`; what is known of the rivals is in `rival_claims.CLAIMS`, and its studies in studies/rivals/claims.
"""

import contextlib
import shlex
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import xarray as xr

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.files import check_own, check_writable, data_path, shipped_study, whole
from swarmcensus.basics.fork import beside
from swarmcensus.basics.hints import did_you_mean
from swarmcensus.paper import claims, page, report
from swarmcensus.paper.evaluations import PAPER, Evaluation, evaluation
from swarmcensus.paper.figures import PaperFigure
from swarmcensus.paper.page import Reproduction
from swarmcensus.runs.collect import Progress, Reporting
from swarmcensus.runs.pools import compile_for
from swarmcensus.runs.running import run, work_of
from swarmcensus.studies.study import Study

FOLDERS = {"paper": "reproduction"}  # where each goes
STUDIES = {"rivals": "rivals/claims"}  # where its studies are, if not in a folder of its name
TAKEN_OVER = 0.05  # seconds: from there on it shows that simulations are not all of this call


def reproduce(
    out: str | Path | None = None,
    *,
    of: str = "paper",
    trials: int | None = None,
    seed: int | None = None,
    jobs: int | None = None,
    only: str | Iterable[str] | None = None,
    fresh: bool = False,
    reporting: Reporting | None = None,
    say: Callable[[str], None] = print,
) -> Reproduction:
    """Run what was published, and write datasets, figures, claims.json and index.html to the folder `out`.

    `of` is "paper", or "rivals" for what is known of other algorithms; by default `out` is "reproduction", or
    "reproduction-rivals". `trials` and `seed` replace those of the study files. `only` names parts, as "fig2" or
    "claims", and runs nothing that they do not need. `reporting(label)` is a context that gives the callback for
    `run`'s progress, here of all studies together; `say` gets a line a stage.

    Raises InputError for what is not known and, before anything is run, for a folder that cannot be written. Ctrl-C
    raises Interrupted; what was done is then in `out`, and the same call goes on from there, unless `fresh`.
    """
    this = evaluation(of)
    parts, out = _parts(this, only), Path(out or FOLDERS.get(of, f"reproduction-{of}"))
    figures = [figure for figure in this.figures if figure.name in parts]
    checks = this.claims if "claims" in parts else ()
    needed = {view.study for figure in figures for view in figure.views}
    needed |= {study for claim in checks for study in claim.studies}
    files = [path for path in sorted(shipped_study(STUDIES.get(of, of)).glob("*.toml")) if path.stem in needed]
    studies = {path.stem: Study.load(path).with_(trials=trials, seed=seed) for path in files}
    stems = [out / "figures" / figure.name for figure in figures]
    check_own(out / "index.html", lambda text: f"<title>{this.title}</title>" in text, "reproduce")
    check_writable(out / "claims.json")
    for path in [data_path(out, name) for name in studies] + [stem.with_suffix(".png") for stem in stems]:
        check_writable(path)

    seconds: dict[str, float] = {}

    def took(name: str, spent: float, more: str = "") -> None:
        seconds[name] = round(spent, 3)
        say(f"{name}: {seconds[name]:.1f} s{more}, {page.CLOCK}")

    @contextlib.contextmanager
    def stage(name: str) -> Iterator[None]:
        begun = time.monotonic()
        yield
        took(name, time.monotonic() - begun)

    datasets, compiled, simulated = _simulate(out, studies, jobs, fresh, reporting, say)
    if compiled:
        took("compile", compiled)
    if datasets:
        every = sum(data.attrs["wall_seconds"] for data in datasets.values())
        took("simulate", every, " with earlier calls" if every - simulated > TAKEN_OVER else "")
    drawn, outcomes = [], []
    if figures:
        with stage("figures"):
            drawn = list(zip(figures, _drawn(figures, datasets, stems), strict=True))
    if checks:
        with stage("claims"):
            outcomes = claims.check(datasets, checks)
            _write(out / "claims.json", report.as_json(outcomes, datasets, this.source))
    done = Reproduction(out, _command(this, out, trials, seed, parts), datasets, drawn, outcomes, seconds, this)
    with stage("page"):
        _write(done.page, page.html(done))
    return done


def _parts(this: Evaluation, only: str | Iterable[str] | None) -> list[str]:
    asked = [only] if isinstance(only, str) else list(only or this.parts)
    for part in asked:
        if part not in this.parts:
            hint, known = did_you_mean(part, this.parts), ", ".join(this.parts)
            raise InputError(f"there is no part {part!r} of the {this.name}: {hint}known are {known}")
    return [part for part in this.parts if part in asked]


def _command(this: Evaluation, out: Path, trials: int | None, seed: int | None, parts: list[str]) -> str:
    words = ["swarmcensus", "reproduce", *([this.name] if this is not PAPER else []), "--out", str(out)]
    for option, value in (("--trials", trials), ("--seed", seed)):
        words += [option, str(value)] if value is not None else []
    return shlex.join(words + (["--only", *parts] if len(parts) < len(this.parts) else []))


def _simulate(
    out: Path,
    studies: Mapping[str, Study],
    jobs: int | None,
    fresh: bool,
    reporting: Reporting | None,
    say: Callable[[str], None],
) -> tuple[dict[str, xr.Dataset], float, float]:
    """The results of all studies, and how long this call compiled and simulated."""
    settings = {name: study.settings() for name, study in studies.items()}
    trials = {name: study.trials * len(settings[name]) for name, study in studies.items()}
    work = {name: work_of(study, settings[name]) for name, study in studies.items()}
    datasets: dict[str, xr.Dataset] = {}
    begun = compiled = time.monotonic()
    with reporting("reproduce") if reporting else contextlib.nullcontext() as progress:

        def show(now: Progress) -> None:
            if progress:
                before, work_before = (sum(each[name] for name in datasets) for each in (trials, work))
                total, work_total = sum(trials.values()), sum(work.values())
                done, work_done = int(before) + now.done, work_before + now.work_done
                progress(Progress(done, total, work_done, work_total, now.note, steps=now.steps))

        def tell(note: str, steps: tuple[int, int]) -> None:
            show(Progress(0, 0, 0.0, 0.0, note, steps=steps))

        if any(fresh or not data_path(out, name).exists() for name in studies):  # of all studies: two compile at a time
            compile_for([(study, settings[name]) for name, study in studies.items()], tell)
            compiled = time.monotonic()
        for name, study in studies.items():
            datasets[name] = run(study, jobs=jobs, progress=show, out=data_path(out, name), fresh=fresh, say=say)
    return datasets, compiled - begun, time.monotonic() - compiled


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
