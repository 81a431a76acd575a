from . import selftest as selftest
from .headers import bare as bare, header as header, number_type as number_type, unit_of as unit_of
from .log_header import logged as logged
from .messages import codec as codec, codec_unit as codec_unit, messages_of as messages_of, owed_numbers as owed_numbers
from .pieces import BOARDS as BOARDS, filled as filled, piece as piece
from .reserved import OF_FIELDS as OF_FIELDS
from .texts import quoted as quoted
from .unit import in_c as in_c, parameter_in_c as parameter_in_c
