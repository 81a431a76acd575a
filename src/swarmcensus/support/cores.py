"""How many cores this process may use."""

import contextlib
import math
import os
from pathlib import Path, PurePosixPath

GROUPS = Path("/sys/fs/cgroup")
OWN_GROUPS = Path("/proc/self/cgroup")


def cores() -> int:
    """The cores that the system lets this process use: of its machine, its affinity and its container's quota."""
    most = [len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1]
    with contextlib.suppress(OSError):  # quotas of Linux's control groups, version 2, and of those around them
        for line in OWN_GROUPS.read_text(encoding="utf-8").splitlines():
            group = PurePosixPath(line.removeprefix("0::"))
            for folder in (GROUPS / str(one).lstrip("/") for one in (group, *group.parents)):
                with contextlib.suppress(OSError, ValueError):  # no such limit, or "max"
                    quota, period = (folder / "cpu.max").read_text().split()
                    most.append(math.ceil(int(quota) / int(period)))
    return max(1, min(most))
