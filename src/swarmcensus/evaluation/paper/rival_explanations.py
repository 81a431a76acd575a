"""Measured numbers for published results on rivals that are not found here."""

from collections.abc import Sequence

from swarmcensus.evaluation.paper.evidence import Detail, Evidence
from swarmcensus.evaluation.paper.rival_measures import (
    consensus_right,
    consensus_time,
    final_error,
    none_agreed,
    quorums,
    right_deciders,
    settling_time,
)

RULES = ("voter", "majority", "direct-comparison")


def percent(share: float) -> str:
    """A share as text."""
    return f"{100 * share:.0f} %"


def quality_helps(evidence: Evidence, _: Sequence[Detail]) -> str:
    """How trials on the harder floor end."""
    hard = {"fill_ratio": 0.55, "floor": "tiles"}
    right, open_ = (
        [percent(float(of(evidence, "opinions", brain=rule, **hard)[0])) for rule in RULES]
        for of in (consensus_right, none_agreed)
    )
    return (
        f"On the harder floor the consensus is right in {right[2]} of trials of direct comparison, {right[0]} of the "
        f"voter's and {right[1]} of the majority's. None is found within ten minutes in {open_[2]}, {open_[0]} and "
        f"{open_[1]} of them."
    )


def patterns(evidence: Evidence, _: Sequence[Detail]) -> str:
    """How pattern and fill ratio slow each rule."""
    parts = []
    for rule in RULES:
        plain, half, hard = (
            float(consensus_time(evidence, "opinions", brain=rule, fill_ratio=f, floor=floor)[0])
            for f, floor in ((0.66, "tiles"), (0.66, "half"), (0.55, "tiles"))
        )
        parts.append(f"{rule} {half / plain:.2f} times and {hard / plain:.2f} times")
    return f"Black in one piece, and a share of 0.55 in place of 0.66, take so many times as long: {'; '.join(parts)}."


def wrong_messages(evidence: Evidence, _: Sequence[Detail]) -> str:
    """The effect of miscommunication on direct switching and cross-inhibition."""
    clean, noisy, crossed, crossed_noisy = (
        percent(float(quorums(evidence, "switching", brain=brain, miscommunication=noise, fill_ratio=f)[0]))
        for brain, f in (("direct-switching", 0.6), ("cross-inhibition", 0.5))
        for noise in (0.0, 0.15)
    )
    return (
        f"At f = 0.6, {clean} of trials of direct switching end with four in five robots of one colour without "
        f"miscommunication, and {noisy} with it. Of cross-inhibition at f = 0.5 it is {crossed} and {crossed_noisy}."
    )


def neighbouring_bins(evidence: Evidence, details: Sequence[Detail]) -> str:
    """The final errors of three-valued and Boolean opinions."""
    errors = [
        float(final_error(evidence, study, liars=0, fill_ratio=f)[0])
        for study in ("three-valued", "boolean")
        for f in (0.25, 0.55)
    ]
    return (
        f"Where three-valued opinions come to a wrong bin it is one nearby: the mean error is {errors[0]:.3f} at "
        f"f = 0.25 and {errors[1]:.3f} at f = 0.55, and a bin is 0.1 wide; with Boolean ones it is {errors[2]:.3f} and "
        f"{errors[3]:.3f}. There are ten options here, and no more than five in what was published."
    )


def early_robots(evidence: Evidence, details: Sequence[Detail]) -> str:
    """How long three-valued and Boolean opinions take to a consensus."""
    times = [
        float(consensus_time(evidence, study, liars=0, fill_ratio=f)[0])
        for f in (0.25, 0.55)
        for study in ("three-valued", "boolean")
    ]
    return (
        f"Median rounds to a consensus are {times[0]:.0f} of three-valued opinions and {times[1]:.0f} of Boolean ones "
        f"at f = 0.25, and {times[2]:.0f} and {times[3]:.0f} at f = 0.55. There are ten options here, and no more than "
        "five in what was published."
    )


def little_evidence(evidence: Evidence, details: Sequence[Detail]) -> str:
    """How often decisions are right, by threshold and prior."""
    usual = {"feedback": 0.0, "prior": 10.0, "threshold": 0.95, "every": 200.0}
    ways = [usual, usual | {"threshold": 0.99}, usual | {"prior": 40.0}]
    shares = [percent(float(right_deciders(evidence, "bayes-bots", fill_ratio=0.55, **way)[0])) for way in ways]
    return (
        f"At f = 0.55, {shares[0]} of decisions are right with a threshold of 0.95 and a prior of 10, {shares[1]} with "
        f"0.99 and {shares[2]} with a prior of 40. Robots that are not decided when a trial ends are left out."
    )


def soon_settled(evidence: Evidence, _: Sequence[Detail]) -> str:
    """How soon belief sharing settles, and how much slower steps improve it."""
    worlds = (0.55, 0.6, 0.75)
    ticks, linear = (
        [float(settling_time(evidence, "beliefs", brain=brain, fill_ratio=f, **which)[0]) for f in worlds]
        for brain, which in (("belief-sharing", {"every": 10.0}), ("linear-consensus", {"phase": 10.0}))
    )
    fast, slow = (
        [float(final_error(evidence, "beliefs", brain="belief-sharing", every=every, fill_ratio=f)[0]) for f in worlds]
        for every in (10.0, 100.0)
    )
    return (
        f"Belief sharing settles after {min(ticks):.0f} to {max(ticks):.0f} ticks, on what was seen until then; linear "
        f"consensus with phases of a second takes {min(linear):.0f} to {max(linear):.0f}. With a step in ten "
        f"seconds in place of one, its mean errors of {_list(fast)} become {_list(slow)}, for f = 0.55, 0.6 and 0.75."
    )


def _list(numbers: Sequence[float]) -> str:
    return f"{', '.join(f'{n:.3f}' for n in numbers[:-1])} and {numbers[-1]:.3f}"
