"""Made-up results for figures, and what a figure has drawn."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text

PAPER = [f"{a:.3f}" for a in np.arange(0.525, 0.98, 0.05)] + ["U(0.525,0.975)"]


def study(accuracies=PAPER, robots=8, trials=5, checkpoints=(10, 100), seed=0, **coordinates) -> xr.Dataset:
    """Results as a study would leave them, all trials run; `coordinates` are one value or one a setting."""
    rng = np.random.default_rng(seed)
    shape = (len(accuracies), trials, robots)
    per_robot = ("setting", "trial", "robot")
    same = {"topology": "ring", "brain": "minimalistic", "robots": robots, "density": np.nan}
    same |= {"fill_ratio": 0.55, "rounds": 1000, "observations_per_round": 10} | coordinates
    right = rng.integers(0, robots + 1, (shape[0], len(checkpoints), trials)) / robots
    return xr.Dataset(
        {
            "convergence_round": (per_robot, rng.integers(0, 1001, shape).astype(np.int32)),
            "convergence_error": (per_robot, rng.gamma(1, 0.02, shape)),
            "local_convergence_step": (per_robot, rng.integers(2000, 10001, shape).astype(np.int32)),
            "local_convergence_error": (per_robot, rng.gamma(1, 0.05, shape)),
            "correct": (("setting", "checkpoint", "trial"), right),
        },
        {k: ("setting", np.broadcast_to(v, shape[0])) for k, v in same.items()}
        | {"accuracy": ("setting", list(accuracies)), "checkpoint": list(checkpoints)},
    )


def forget(results: xr.Dataset, **where) -> xr.Dataset:
    """The same results where these trials or robots were never run."""
    results = results.copy(deep=True)
    for name in results.data_vars:
        place = {k: v for k, v in where.items() if k in results[name].dims}
        if set(place) == set(where):
            results[name][place] = -1 if results[name].dtype.kind == "i" else np.nan
    return results


def drawn(axes: Axes, label: str) -> np.ndarray:
    """The (x, y) of all points drawn under this label, in order of x."""
    points = [line.get_xydata() for line in axes.lines if line.get_label() == label]
    return np.array(sorted(map(tuple, np.concatenate(points)))) if points else np.empty((0, 2))


def texts(figure: Figure) -> str:
    figure.draw_without_rendering()
    return "\n".join(t.get_text() for t in figure.findobj(lambda a: hasattr(a, "get_text")))


def assert_fits(figure: Figure) -> None:
    """All that is drawn stands on the paper, and no text upon a panel's caption or the title."""
    figure.draw_without_rendering()
    captions = [t for ax in figure.axes for t in (ax._left_title,) if t.get_text()]
    others = [t for ax in figure.axes for t in (*ax.texts, ax.xaxis.label, ax.yaxis.label) if t.get_text()]
    others += [t for ax in figure.axes if ax.get_legend() for t in ax.get_legend().findobj(Text) if t.get_text()]
    others += [t for t in figure.texts if t.get_text()]
    boxes = {id(t): t.get_window_extent() for t in captions + others}
    axes = [axis.get_tightbbox() for ax in figure.axes for axis in (ax.xaxis, ax.yaxis)]
    keys = [ax.get_legend().get_window_extent() for ax in figure.axes if ax.get_legend()]
    for box in filter(None, (*boxes.values(), *axes, *keys)):
        assert min(box.x0, box.y0, figure.bbox.x1 - box.x1, figure.bbox.y1 - box.y1) >= -1, box
    for caption in captions:
        for other in captions + others:
            assert other is caption or not boxes[id(caption)].overlaps(boxes[id(other)]), (caption, other)
