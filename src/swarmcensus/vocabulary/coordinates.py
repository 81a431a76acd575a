"""Everything that settings differ in, each declared once: the coordinates of the dataset along `setting`.

A new coordinate is one entry of `ALL`, and a value in `_coordinates` of studies/settings.py. Parameters of brains are
coordinates too, by their own names; they have no entry.
"""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Coordinate:
    """A coordinate, with how tables, captions and axes call it.

    `caption` formats a value in a caption, by default as "name = value". `idle` is what a caption says of a value that
    says nothing (an empty text, NaN), where that would be missed. `title` names an axis or a key, `plural` several
    values. `counts` is whether its values often span decades. `blank` stands for a setting that has no value, where
    other settings of the study have one. `always` is whether every file has it. `world` is where it means something:
    elsewhere it is NaN, an empty text or left out.
    """

    name: str
    type: Literal["text", "number", "whole number"]
    page: str  # what docs/data-format.md says
    caption: str = ""
    idle: str = ""
    title: str = ""
    plural: str = ""
    counts: bool = False
    blank: int | str | None = None
    always: bool = True
    world: Literal["any", "networks", "moving"] = "any"


ALL = (
    Coordinate("brain", "text", "name or path, as in the study file", caption="{}", plural="brains"),
    Coordinate(
        "topology", "text",
        "name, with non-default keys, `torus(columns=5)`; an edge list's file without its ending; a networkx function "
        "with its arguments",
        caption="{}", plural="topologies",
    ),
    Coordinate(
        "robots", "whole number", "*N*", caption="N = {:,.0f}", title="robots $N$", plural="numbers of robots",
        counts=True,
    ),
    Coordinate(
        "density", "number", "*D* of robots", caption="D = {}", title="density $D$", plural="densities", counts=True,
        world="moving",
    ),
    Coordinate(
        "side", "number", "*L* in metres, to twelve digits",
        caption="L = {} m", title="side of the arena $L$ (m)", plural="sides of the arena", counts=True, world="moving",
    ),
    Coordinate(
        "accuracy", "text",
        "`0.675`, `U(0.525,0.975)`, `N(0.75,0.1)`, `beta(8.0,2.0)`, `black=0.9 white=0.6`, or `0.9 drift=-1e-05 "
        "least=0.6`",
        caption="accuracy {}", title="sensor accuracy", plural="accuracies",
    ),
    Coordinate(
        "assumed_accuracy", "text",
        "in the same forms, or `error=N(0.0,0.05)`; equal to `accuracy`, or to its start, if robots know their sensors",
        caption="assumed accuracy {}", plural="assumed accuracies",
    ),
    Coordinate(
        "fill_ratio", "number", "*f*; where it changes, that of the last round", caption="f = {}",
        title="fill ratio $f$", plural="fill ratios",
    ),
    Coordinate(
        "floor", "text",
        "`tiles`, `clusters(0.2)`, `stripes(0.5)`, `half`, `image(leaves)`, `image(leaves,dither)`, `hills(0.3)`",
        caption="floor {}", plural="floors", world="moving",
    ),
    Coordinate("link_success", "number", "the probability that a message gets through", caption="link success {}"),
    Coordinate(
        "rounds", "whole number", "*C*, or ticks where robots move", caption="C = {:,.0f}", title="rounds $C$",
        plural="numbers of rounds", counts=True,
    ),
    Coordinate(
        "observations_per_round", "whole number", "*R*, 1 where robots move", caption="R = {:,.0f}",
        title="observations per round $R$", counts=True,
    ),
    Coordinate(
        "members", "text",
        "[members](study-file.md#members), `0.1 liar.py, not honest`; only if a study has any",
        caption="{}", idle="robots alike", plural="mixtures of robots", always=False,
    ),
    Coordinate(
        "liars", "whole number", "how many robots are not honest; only with `members`",
        caption="{:,.0f} liars", plural="numbers of liars", blank=0, always=False,
    ),
    Coordinate(
        "adversary", "text",
        "the liars' [adversaries](adversaries.md) or brains, with parameters, or how else they differ; empty if nobody "
        "lies",
        caption="{}", idle="nobody lies", plural="adversaries", always=False,
    ),
    Coordinate(
        "fill_ratio_change", "text",
        "how *f* [changes](study-file.md#floors-that-change), `0.9 to 0.1 at 200 until 600`, or empty; only if it "
        "changes in any setting",
        caption="f {}", idle="f stays", always=False,
    ),
    Coordinate(
        "message_delay", "whole number",
        "[delay](study-file.md#late-messages) in rounds; only if above 0 in any setting",
        caption="delay {:,.0f}", title="message delay (rounds)", plural="message delays", blank=0, always=False,
        world="networks",
    ),
    Coordinate(
        "precision", "text",
        "`single` or `double` [precision](study-file.md#numbers-of-robots); only if single in any setting",
        caption="{} precision", title="precision", plural="precisions", blank="double", always=False,
    ),
    Coordinate(
        "message", "text",
        "format of [messages](study-file.md#numbers-of-robots), `ratio16`, or `float16, no feedback`; only if any "
        "setting has one",
        caption="messages as {}", title="message format", plural="message formats", blank="double", always=False,
    ),
)  # fmt: skip
COORDINATES = {coordinate.name: coordinate for coordinate in ALL}
NUMERIC = {  # worked out from `accuracy`, a text, when Python opens results
    coordinate.name: coordinate
    for coordinate in (
        Coordinate(
            "accuracy_black", "number", "b, how likely black is read as black: the mean over robots, in round 1",
            title="sensor accuracy $b$", always=False,
        ),
        Coordinate(
            "accuracy_white", "number", "w, how likely white is read as white: the mean over robots, in round 1",
            title="sensor accuracy $w$", always=False,
        ),
        Coordinate(
            "accuracy_spread", "number", "how far robots differ: the standard deviation of b or w, the larger one",
            title="spread of sensor accuracies", always=False,
        ),
    )
}  # fmt: skip
IN_CAPTIONS = (  # in this order
    "topology", "brain", "robots", "density", "side", "fill_ratio", "fill_ratio_change", "floor", "rounds",
    "observations_per_round", "link_success", "message_delay", "precision", "message", "assumed_accuracy", "accuracy",
    "checkpoint", "members", "adversary", "liars",
)  # fmt: skip
ROUNDS = Coordinate(  # of quantities that are measured at checkpoints
    "checkpoint", "whole number", "a round after which decisions were recorded", caption="after {:,.0f}", counts=True
)
OF_FIGURES = COORDINATES | NUMERIC | {ROUNDS.name: ROUNDS}


def caption_form(name: str) -> str:
    """How a caption formats a value of a coordinate, or of a brain's parameter."""
    known = OF_FIGURES.get(name)
    return known.caption if known and known.caption else name + " = {}"


def idle_caption(name: str) -> str:
    """What a caption says of a value that says nothing; empty where it leaves it out."""
    return COORDINATES[name].idle if name in COORDINATES else ""


def title_of(name: str) -> str:
    """What an axis or a key calls a coordinate."""
    known = OF_FIGURES.get(name)
    return known.title if known and known.title else name.replace("_", " ").replace("$", r"\$")


def plural_of(name: str) -> str:
    """What several values of a coordinate are called."""
    known = COORDINATES.get(name)
    return known.plural if known and known.plural else f"values of {name}"
