"""Return values of a brain's `steer`, `interval` and `broadcast`, for Numba: it can neither index nor unpack "a pair or
None", and its messages about other types are long."""

import numba
from numba.extending import intrinsic, overload


@intrinsic
def unwrapped(context, value):
    """An optional value as whether it is there, and the value."""

    def generate(target, builder, signature, arguments):
        optional = target.make_helper(builder, value, value=arguments[0])
        return target.make_tuple(builder, signature.return_type, (optional.valid, optional.data))

    return numba.types.Tuple((numba.types.boolean, value.type))(value), generate


def chosen(command):
    """Whether a robot wants to go anywhere, its speed and its turn."""
    return (False, 0.0, 0.0) if command is None else (True, float(command[0]), float(command[1]))


def is_number(kind):
    """Whether values of this Numba type are real numbers."""
    return isinstance(kind, numba.types.Integer | numba.types.Float)


def is_pair(kind):
    """Whether values of this Numba type are two real numbers."""
    return isinstance(kind, numba.types.BaseTuple) and len(kind) == 2 and all(map(is_number, kind.types))


@overload(chosen)
def compiled_chosen(command):
    """`chosen` in machine code: for None, for a pair, and for either."""
    if isinstance(command, numba.types.NoneType):
        return lambda command: (False, 0.0, 0.0)
    pair = command.type if isinstance(command, numba.types.Optional) else command
    if not is_pair(pair):
        # no NumbaError, which would only be counted among the reasons why no implementation was found
        raise TypeError(f"steer gives {pair}, neither two numbers, a speed and a turn, nor None")
    if not isinstance(command, numba.types.Optional):
        return lambda command: (True, float(command[0]), float(command[1]))

    def either(command):
        there, pair = unwrapped(command)
        if there:
            return True, float(pair[0]), float(pair[1])
        return False, 0.0, 0.0

    return either


def ends_of(interval):
    """The low and the high end of what `interval` gives."""
    low, high = interval
    return float(low), float(high)


@overload(ends_of)
def compiled_ends_of(interval):
    """`ends_of` in machine code."""
    if not is_pair(interval):
        raise TypeError(f"interval gives {interval}, not two numbers, low and high")
    return lambda interval: (float(interval[0]), float(interval[1]))


def spoken(message, blank):
    """Whether `broadcast` says anything, and what; `blank` is a message of zeros."""
    return (False, blank) if message is None else (True, message)


@overload(spoken)
def compiled_spoken(message, blank):
    """`spoken` in machine code."""
    if isinstance(message, numba.types.NoneType):
        return lambda message, blank: (False, blank)
    if not isinstance(message, numba.types.Optional):
        return lambda message, blank: (True, message)
    return lambda message, blank: unwrapped(message)


def whole_vector(part, long):
    """Raise ValueError for a vector of a message that is not as long as MESSAGE says."""
    if len(part) != long:
        raise ValueError("broadcast gives a vector of another length than MESSAGE says")


@overload(whole_vector)
def compiled_whole_vector(part, long):
    """`whole_vector` in machine code."""
    if isinstance(part, numba.types.Number):
        raise TypeError("broadcast gives a number where MESSAGE says a vector")
    return whole_vector
