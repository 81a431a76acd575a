"""What was published about rivals, each as a check on measured data; the rules are those of `claims`.

Sentences are ours, and tell what an abstract says or, where the section says "not checked", what is generally known.
Abstracts give orderings and effects, rarely numbers: margins and what counts as a consensus are choices of ours.
"""

from swarmcensus.paper import bayesian_claims, number_claims, opinion_claims
from swarmcensus.paper.evidence import Claim

CLAIMS: tuple[Claim, ...] = (*opinion_claims.CLAIMS, *bayesian_claims.CLAIMS, *number_claims.CLAIMS)
