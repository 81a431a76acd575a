"""The shipped brains, one file each, and what figures call them."""

from collections.abc import Mapping, Sequence

TITLES = {
    "alone": "Alone",
    "asdf": "ASDF",
    "bayes-bots": "Bayes Bots",
    "bayes-cpf": "BayesCPF",
    "belief-sharing": "Belief sharing",
    "belief-sharing-indexed": "Belief sharing, indexed",
    "census": "Census",
    "changing-floor": "Bayes Bots, changing floor",
    "commons": "Commons",
    "consensus-innovations": "Consensus + innovations",
    "covariance-intersection": "Covariance intersection",
    "cross-inhibition": "Cross-inhibition",
    "direct-comparison": "Direct comparison",
    "direct-switching": "Direct switching",
    "gated-mean": "Gated mean",
    "information-filter": "Information filter",
    "kalman-consensus": "Kalman consensus",
    "leaver": "Leaver",
    "legacy": "Legacy (paper)",
    "linear-consensus": "Linear consensus",
    "majority": "Majority rule",
    "minimalistic": "Minimalistic (paper)",
    "oracle": "Oracle",
    "recurrent": "Recurrent net",
    "self-taught": "Self-taught",
    "steadfast": "Steadfast",
    "sure": "Sure",
    "swift": "Swift",
    "three-state": "Three-state",
    "tracking": "Tracking",
    "voter": "Voter model",
    "w-msr": "W-MSR",
    "weighted-voter": "Weighted voter model",
}


def namesakes(brains: Sequence[str], labels: Mapping[str, str]) -> tuple[str, str, str] | None:
    """Two of these brains that tables or figures would call alike, and how; None if there are none."""
    for titles in ({}, TITLES):  # of tables, of figures
        by_name: dict[str, str] = {}
        for brain in brains:
            name = labels.get(brain, titles.get(brain, brain))
            if by_name.setdefault(name, brain) != brain:
                return by_name[name], brain, name
    return None
