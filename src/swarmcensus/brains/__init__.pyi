from . import adversary as adversary, robot_math as robot_math
from .adversary import Adversary as Adversary, exists as exists
from .adversary_source import lying_brain as lying_brain
from .brain import (
    PLUGINS as PLUGINS,
    Brain as Brain,
    find as find,
    is_shipped as is_shipped,
    load as load,
    parse as parse,
    shipped as shipped,
    unloaded as unloaded,
)
from .brain_file import Program as Program
from .contract import FUNCTIONS as FUNCTIONS, MAY_HAVE as MAY_HAVE
from .endless_calls import Lines as Lines, TooManyLines as TooManyLines
from .fields import (
    LARGEST as LARGEST,
    Value as Value,
    Vector as Vector,
    length as length,
    numbers as numbers,
    places as places,
    slots as slots,
)
from .float32 import (
    CONSTANTS as CONSTANTS,
    MODULE as MODULE,
    ROUND as ROUND,
    codec_source as codec_source,
    in_single as in_single,
    rounded_to_single as rounded_to_single,
)
from .kinds import (
    NOTHING as NOTHING,
    REAL as REAL,
    RECORD as RECORD,
    TRUTH as TRUTH,
    VECTOR as VECTOR,
    WHOLE as WHOLE,
    Kind as Kind,
    Kinds as Kinds,
)
from .packing import (
    BYTES as BYTES,
    FORMATS as FORMATS,
    MOST as MOST,
    PLAIN as PLAIN,
    READ as READ,
    STEPS as STEPS,
    Format as Format,
    Numbers as Numbers,
    Part as Part,
    Precision as Precision,
    bytes_of as bytes_of,
    parts as parts,
)
from .requirements import names_in as names_in
from .syntax import (
    BELIEFS as BELIEFS,
    INTERVAL as INTERVAL,
    arguments_of as arguments_of,
    functions_of as functions_of,
    may_be_none as may_be_none,
)
