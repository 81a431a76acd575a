"""Published results on rivals as checks on measured data, by the same rules as in `claims`.

The sentences are ours. They state what an abstract says or, where the section says "not checked", what is generally
known. Abstracts give orderings and effects, rarely numbers, so margins and definitions of consensus are our choices.
"""

from swarmcensus.paper import bayesian_claims, number_claims, opinion_claims
from swarmcensus.paper.evidence import Claim

CLAIMS: tuple[Claim, ...] = (*opinion_claims.CLAIMS, *bayesian_claims.CLAIMS, *number_claims.CLAIMS)
