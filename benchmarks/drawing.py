"""What the figures of benchmarks have in common: a colour a brain, of Okabe and Ito's, and panels without a frame."""

import matplotlib
import matplotlib.pyplot as plt

COLOURS = ("#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
MARKERS = "os^Dvx"


def panels(rows, columns, width, height):
    """A figure, and its axes one after the other."""
    matplotlib.use("agg")
    figure, axes = plt.subplots(
        rows, columns, figsize=(width, height), layout="constrained", sharex=True, sharey=True, squeeze=False
    )
    for one in axes.flat:
        one.spines[["top", "right"]].set_visible(False)
    return figure, axes.flat


def save(figure, path, brains, handles):
    """With one key below all panels."""
    figure.legend(handles, brains, loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    figure.savefig(path, dpi=160)
