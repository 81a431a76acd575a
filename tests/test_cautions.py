"""Readers are told where a robot converged before it had seen anything."""

import warnings

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.cautions import settled_at_start, warn_of_start
from swarmcensus.cli import main

STUDY = """
trials = 4
[swarm]
robots = 400
accuracy = 0.9
[world]
topology = "full"
fill_ratio = [0.5, 0.7]
[schedule]
rounds = 20
observations_per_round = 100
"""


def test_swarms_that_begin_at_the_truth_are_warned_of(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.toml").write_text(STUDY)
    assert main(["run", "s.toml"]) == 0
    said = capsys.readouterr().err
    assert "warning: setting 0: 100 % of the robots have K = 0" in said
    assert "by delta = 0.01 or more" in said
    assert (sc.load("s.nc")["convergence_round"][0] == 0).all()
    (tmp_path / "s.toml").write_text(STUDY.replace("[0.5, 0.7]", "0.7"))
    assert main(["run", "s.toml", "--out", "t.nc"]) == 0
    assert "K = 0" not in capsys.readouterr().err


def test_shares_are_of_the_robots_that_were_run(small_results):
    data = small_results.copy(deep=True)
    when = data["convergence_round"]
    when[:] = np.where(when >= 0, 5, when)
    assert (settled_at_start(data) == 0).all()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_of_start(data)
    robots = int(data["robots"][3])
    when[3, 0, :robots] = 0  # one trial of four
    when[3, 3] = -1
    when[4] = -1
    shares = settled_at_start(data)
    assert shares[3] == pytest.approx(1 / 3)
    assert np.isnan(shares[4])
    when[7, 0, 0] = 0
    with pytest.warns(UserWarning, match=r"^setting 3: 33 % of the robots have K = 0"):
        warn_of_start(data)
    when[:] = 0
    with pytest.warns(UserWarning, match=r"^settings 0, 1, 2, 3, 4, 5, 6, 7, \.\.\.: up to 100 % of"):
        warn_of_start(data)
