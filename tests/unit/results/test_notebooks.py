"""What notebooks show: a summary of results, a trace's curves, and a line while a study runs."""

import sys
import types

import pytest

import swarmcensus as sc
from swarmcensus.figures.notebook import shown
from swarmcensus.runs import progress
from swarmcensus.runs.collect import Progress

CELLS = [
    "import swarmcensus as sc\nstudy = sc.Study(trials=2, swarm={'robots': [2, 3], 'accuracy': 0.8}, "
    "world={'topology': 'ring', 'fill_ratio': 0.55}, schedule={'rounds': 5})\nstudy",
    "results = sc.run(study)\nresults",
    "sc.replay(results, setting=1, trial=0)",
    "import xarray as xr\nxr.Dataset({'mine': 1})",
]


@pytest.mark.long
def test_a_notebook_shows_them():
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in CELLS])
    nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    outputs = [next(o for o in cell.outputs if o.output_type == "execute_result").data for cell in notebook.cells]
    results, trace, other = (output["text/html"] for output in outputs[1:])
    assert "2 settings of 2 trials" in outputs[0]["text/plain"]
    assert "2 settings, 4 of 4 trials done" in results
    assert "data:image/png;base64," in trace
    assert "mine" in other
    assert "<details><summary>the dataset" not in other
    assert outputs[1]["text/plain"].startswith("<xarray.Dataset>")


def test_results_show_the_numbers_of_their_summary(small_results):
    text = shown(small_results)
    row = sc.summary(small_results).iloc[0]
    assert f"{row['convergence_error']:.3g}" in text
    count = small_results.sizes["setting"]
    assert text.count("<tr") == 1 + min(count, 40) + text.partition("<details>")[2].count("<tr")
    assert "assumed_accuracy" not in text.partition("<details>")[0]
    assert "<summary>the dataset" not in shown(small_results.drop_vars("convergence_round"))


# ---- the line


@pytest.fixture
def display(monkeypatch):
    """What a notebook's cell comes to show, as texts."""
    seen = []

    handle, shell = types.SimpleNamespace(update=lambda what, raw: seen.append(what)), types.SimpleNamespace(kernel=1)
    pages = types.SimpleNamespace(display=lambda what, raw, display_id: seen.append(what) or handle)
    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(get_ipython=lambda: shell))
    monkeypatch.setitem(sys.modules, "IPython.display", pages)
    return seen


def test_line_in_a_notebook(display, monkeypatch):
    with progress.showing(True, "<mine>") as show:
        show(Progress(1, 4, 0.25, 1.0))
    assert not display
    monkeypatch.setattr(progress, "NOTEBOOK_DELAY", 0.0)
    with progress.showing(True, "<mine>") as show:
        show(Progress(0, 0, 0.0, 0.0, "compiling"))
        show(Progress(1, 4, 0.25, 1.0))
        show(Progress(2, 4, 0.5, 1.0))
    texts = [one["text/plain"] for one in display]
    assert texts[0] == "<mine>: compiling"
    assert texts[1] == "<mine>: 1 of 4 trials, starting"
    assert texts[2].startswith("<mine>: 2 of 4 trials, ")
    assert texts[3] == "<mine>: 2 of 4 trials in 0:00"
