"""The options of `watch`."""

import argparse
from pathlib import Path


def add_watch_options(sub: argparse.ArgumentParser) -> None:
    """All of them."""
    sub.add_argument(
        "of",
        type=Path,
        nargs="?",
        metavar="STUDY.toml|RESULTS.nc|BRAIN.py",
        help="default: 25 robots that move",
    )
    sub.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="such as robots=100, setting=3, trial=7, tick=500; may be repeated",
    )
    sub.add_argument("--at", default="", metavar="ADDRESS", help="the moment of somebody's copied link")
    sub.add_argument(
        "--brain",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="a brain file that may be watched too; may be repeated",
    )
    sub.add_argument("--export", type=Path, metavar="FILE.html", help="write the page with this trial in it, and end")
    sub.add_argument("--port", type=_port, default=0, help="default: a free one")
    sub.add_argument("--host", default="127.0.0.1", help="whom to answer to (default: this machine alone)")
    sub.add_argument("--no-browser", action="store_true", help="print the address, and open nothing")


def _port(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= 5 and int(text) <= 65_535):
        raise argparse.ArgumentTypeError(f"{text[:40]!r}: should be a port, from 1 to 65535, or 0 for a free one")
    return int(text)
