"""The shipped brains, one file each, and what figures call them and how they show them."""

from collections.abc import Mapping, Sequence

TITLES = {  # in the order in which figures give them colours and markers: new ones go to the end
    "minimalistic": "Minimalistic (paper)",
    "legacy": "Legacy (paper)",
    "commons": "Commons",
    "swift": "Swift",
    "sure": "Sure",
    "census": "Census",
    "steadfast": "Steadfast",
    "alone": "Alone",
    "oracle": "Oracle",
    "self-taught": "Self-taught",
    "tracking": "Tracking",
    "linear-consensus": "Linear consensus",
    "bayes-bots": "Bayes Bots",
    "information-filter": "Information filter",
    "asdf": "ASDF",
    "bayes-cpf": "BayesCPF",
    "belief-sharing": "Belief sharing",
    "belief-sharing-indexed": "Belief sharing, indexed",
    "changing-floor": "Bayes Bots, changing floor",
    "consensus-innovations": "Consensus + innovations",
    "covariance-intersection": "Covariance intersection",
    "cross-inhibition": "Cross-inhibition",
    "direct-comparison": "Direct comparison",
    "direct-switching": "Direct switching",
    "gated-mean": "Gated mean",
    "kalman-consensus": "Kalman consensus",
    "leaver": "Leaver",
    "majority": "Majority rule",
    "recurrent": "Recurrent net",
    "three-state": "Three-state",
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
