from . import minimalism as minimalism
from .checking import Conformance as Conformance, check as check
from .lives_in_single import single_lives as single_lives
from .quick import caution as caution
from .suite import Check as Check, brain_to_check as brain_to_check
