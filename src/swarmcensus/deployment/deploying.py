"""Makes the folder of a robot."""

from dataclasses import dataclass
from pathlib import Path

from swarmcensus.deployment.folders import new_folder, write_texts
from swarmcensus.deployment.kilobot_files import check_fits, kilobot_files
from swarmcensus.deployment.micropython_files import micropython_files
from swarmcensus.deployment.plans import Plan


@dataclass(frozen=True)
class Deployed:
    """What a folder needs of a robot, in bytes; None where no compiler is there to tell."""

    folder: Path
    files: tuple[str, ...]
    message_bytes: int
    datagram_bytes: int
    memory_bytes: int  # the brain's numbers; on MicroPython each takes more
    flash_bytes: int | None = None
    ram_bytes: int | None = None


def deploy(plan: Plan, folder: Path) -> Deployed:
    """Write the files of a robot into a new folder, whole or not at all. Raises InputError."""
    flash = ram = None
    if plan.radio == "kilobot":
        texts = kilobot_files(plan)
        flash, ram = check_fits(plan, texts)
    else:
        texts = micropython_files(plan)
    with new_folder(folder) as made:
        write_texts(made, texts)
    brain = plan.brain
    return Deployed(folder, tuple(texts), brain.message_bytes, plan.datagram_bytes, brain.memory_bytes, flash, ram)
