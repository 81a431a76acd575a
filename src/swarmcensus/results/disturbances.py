"""What was done to the swarms of some results: which parts of robots failed when, and who lied."""

import json
import tomllib
from typing import Any

import xarray as xr

from swarmcensus.basics.counting import counted


def disturbances(data: xr.Dataset) -> list[str]:
    """A line for each fault of its studies, and one for the adversaries of its settings; none where all was well."""
    texts = json.loads(data.attrs["merged"]) if "merged" in data.attrs else [data.attrs["study"]]
    faults = [_told(fault) for text in texts for fault in tomllib.loads(text).get("faults", [])]
    liars = sorted({name for name in data["adversary"].values.tolist() if name}) if "adversary" in data.coords else []
    return [*dict.fromkeys(faults), *([f"adversaries among the robots: {', '.join(liars)}"] if liars else [])]


def _told(fault: dict[str, Any]) -> str:
    """Such as "faults: 3 robots stop sensing and talking, from 50 on"."""
    some, stop, at = fault["robots"], fault["stop"], fault["at"]
    who = f"{100 * some:g} % of robots stop" if isinstance(some, float) else f"{counted(some, 'robot')} stop"
    who = "1 robot stops" if some == 1 and isinstance(some, int) else who
    what = stop if isinstance(stop, str) else " and ".join(stop)
    until = f" until {fault['until']}" if "until" in fault else " on"
    return f"faults: {who} {what}, from {at}{until}"
