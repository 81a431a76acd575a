"""The script that makes a shell complete commands, options, files, and what can be used by name."""

import argparse
import importlib
import shlex
from pathlib import Path
from typing import Any

SHELLS = ("bash", "zsh", "fish", "tcsh")
BRAINS, ADVERSARIES = "brains.brain", "brains.adversary"
NAMED = {
    "adversary": ADVERSARIES, "brain": BRAINS, "check": BRAINS, "cost": BRAINS, "floor": "worlds.patterns",
    "kind": "figures.kinds", "lie": ADVERSARIES, "show": BRAINS, "target": "robots.targets",
    "topology": "worlds.wiring", "wrapping": BRAINS,
}  # fmt: skip  # options by what they name, and the module that finds it
ARGUMENTS = ("deploy", "swarm")  # the commands with a brain as their argument `what`


def completion(top: argparse.ArgumentParser, shell: str) -> str:
    """The script for a shell, from the parser of all commands, which is changed."""
    import shtab

    [commands] = [action for action in top._actions if isinstance(action, argparse._SubParsersAction)]
    for command, sub in commands.choices.items():
        for action in sub._actions:
            names = [] if action.choices else _names(command, action.dest)
            takes = _files(action)
            if names and takes:
                action.complete = _files_and(names, f"{command}_{action.dest}")  # type: ignore[attr-defined]
            elif names:
                action.choices = names
            elif takes:
                action.complete = shtab.DIRECTORY if takes == "FOLDER" else shtab.FILE  # type: ignore[attr-defined]
    return str(shtab.complete(top, shell))


def _names(command: str, option: str) -> list[str]:
    """What an option or argument of a command may name."""
    if (command, option) == ("new", "what"):
        from swarmcensus.support.files import shipped_studies

        return ["study", "brain", *shipped_studies()]
    if (command, option) == ("reproduce", "of"):
        return ["paper", "rivals"]
    module = BRAINS if option == "what" and command in ARGUMENTS else NAMED.get(option)
    return [*importlib.import_module(f"swarmcensus.{module}").PLUGINS.names] if module else []


def _files(action: argparse.Action) -> str:
    """FILE or FOLDER if a value may be one, and otherwise nothing."""
    if action.metavar == "FOLDER":
        return "FOLDER"
    known = str(action.metavar)
    return "FILE" if action.type is Path or "BRAIN" in known or "FILE" in known else ""


def _files_and(names: list[str], what: str) -> dict[str, Any]:
    """How each shell completes files and names; `what` makes the name of bash's function unique."""
    words = shlex.join(names)
    return {
        "bash": f"_swarmcensus_files_{what}",
        "zsh": f"{{_files; compadd -- {words}}}",
        "fish": f"{words} (__fish_complete_path (commandline -ct))",
        "tcsh": f"`echo {words} *`",
        "preamble": {"bash": f'_swarmcensus_files_{what}() {{ compgen -f -W "{words}" -- "$1"; }}'},
    }
