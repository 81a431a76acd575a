from . import selftest as selftest
from .comments import quoted as quoted
from .headers import header as header, unit_of as unit_of
from .messages import codec as codec, messages_of as messages_of, owed_numbers as owed_numbers
from .pieces import BOARDS as BOARDS, filled as filled, piece as piece
