"""The options of the commands that one begins with."""

import argparse
from pathlib import Path


def add_new_options(sub: argparse.ArgumentParser) -> None:
    """Of `new`."""
    sub.add_argument("what", choices=("study", "brain"), metavar="study|brain", help="what to begin")
    sub.add_argument(
        "file",
        type=Path,
        nargs="?",
        metavar="FILE",
        help="default: my_study.toml or my_brain.py, here, with a number where that is taken",
    )


def add_studies_options(sub: argparse.ArgumentParser) -> None:
    """Of `studies`."""
    what = sub.add_mutually_exclusive_group()
    what.add_argument("name", nargs="?", metavar="NAME", help="one to copy, with the files that it names")
    what.add_argument("--schema", action="store_true", help="print the JSON schema of study files, for editors")
    sub.add_argument("--out", type=Path, metavar="FILE.toml", help="default: its own name, here")


def add_completion_options(sub: argparse.ArgumentParser) -> None:
    """Of `completion`."""
    sub.add_argument(
        "shell",
        choices=("bash", "zsh", "tcsh"),
        metavar="bash|zsh|tcsh",
        help="for bash: swarmcensus completion bash > ~/.local/share/bash-completion/completions/swarmcensus",
    )
