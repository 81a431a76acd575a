"""What takes long: tested where SWARMCENSUS_SLOW=1 asks for it; else with fewer cases, or by what is beside it.

slow.txt lists the tests that take more than two seconds of a processor. `SWARMCENSUS_SLOW=1 pytest -n 2 --list-slow`
runs all and writes it anew.
"""

import os
from pathlib import Path

import pytest

SLOW = bool(os.environ.get("SWARMCENSUS_SLOW"))
LONG = 2.0
LIST = Path(__file__).with_suffix(".txt")
# one of each kind of promise is kept wherever tests run, long or not
ALWAYS = (
    "tests/test_conformance.py::test_shipped_brains_conform[minimalistic]",
    "tests/test_conformance.py::test_shipped_brains_conform[commons]",
    "tests/test_conformance.py::test_a_brain_of_ones_own",
    "tests/test_engine.py::test_a_run_is_what_the_brain_file_makes_of_the_same_observations",
    "tests/test_engine.py::test_rounds_are_made_of_their_single_readings",
    "tests/test_engine.py::TestDeterminism::test_python_runs_the_engine_to_the_same_bits",
    "tests/test_steering.py::test_in_cpython_and_on_fixed_networks",
    "tests/test_moving.py::test_a_run_is_its_replay_and_what_the_brain_file_makes_of_it",
    "tests/test_paper.py::test_a_part_runs_only_what_it_needs",
    "tests/test_paper.py::test_all_files_are_there",
    "tests/test_cli.py::test_a_first_session",
    "tests/test_cli.py::test_brains",
    "tests/test_cli.py::test_ctrl_c_stops_within_a_second_and_keeps_what_is_done",
    "tests/test_resuming.py::test_shares_add_up",
    "tests/test_resuming.py::test_a_run_that_was_killed_has_an_early_picture",
    "tests/test_clusters.py::test_a_running_scheduler_gives_the_bits_of_threads",
    "tests/test_merging.py::test_merged_results_are_replayed_plotted_verified_and_grown",
    "tests/test_fuzz.py::test_any_bytes_as_a_study_or_a_cluster",
    "tests/test_fuzz.py::test_results_with_bytes_changed",
    "tests/test_fuzz.py::test_where",
    "tests/test_trust.py::test_whatever_is_changed_is_noticed[rule]",
    "tests/test_leaderboard.py::test_the_shell_prints_the_board_and_the_page_stands_with_its_picture",
    "tests/test_explain.py::test_the_shell_lays_theory_over_three_kinds",
    "tests/test_planning.py::test_the_found_time_is_right_in_other_trials",
    "tests/test_tuning.py::test_a_quadratic_penalty_is_found",
    "tests/test_adversaries.py::test_swarms_with_liars_live_as_by_brute_force",
    "tests/test_steering.py::test_a_run_is_its_replay_and_what_the_brain_file_makes_of_it",
    "tests/test_members.py::test_what_is_measured_is_of_the_honest",
    "tests/test_arena_pictures.py::test_arena_and_film_from_the_command_line",
)


def times(thorough, quick):
    """The first of two where there is time."""
    return thorough if SLOW else quick


def skip_what_takes_long(items):
    """Skips what the list names, unless all is asked for."""
    listed = set() if SLOW else set(LIST.read_text().splitlines())
    for item in items:
        if item.nodeid in listed:
            item.add_marker(pytest.mark.skip(reason="takes long: SWARMCENSUS_SLOW=1 runs it"))


class Clock:
    """Times each test, those that workers ran too, and at the end writes the list."""

    def __init__(self):
        self.long = set()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        item.began = sum(os.times()[:4])
        return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item, call):
        if call.when == "teardown":
            item.user_properties.append(("processor", sum(os.times()[:4]) - item.began))
        return (yield)

    def pytest_runtest_logreport(self, report):
        took = dict(report.user_properties).get("processor", 0.0)
        if took > LONG and not report.nodeid.startswith(ALWAYS):
            self.long.add(report.nodeid)

    def pytest_sessionfinish(self, session):
        if not hasattr(session.config, "workerinput"):
            LIST.write_text("".join(f"{one}\n" for one in sorted(self.long)))
