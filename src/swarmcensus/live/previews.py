"""A trace of which CPython computes the first seconds in another process, while this one compiles."""

import threading
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, wait
from functools import partial, partialmethod
from typing import Any

from swarmcensus.live.interpreted import INTERPRETER, answer_of
from swarmcensus.simulation import Stepped, Stretch, Trace, packed
from swarmcensus.studies import Setting, addresses

AT_ONCE = 1500  # ticks of a robot that CPython computes at a time: a tenth of a second
KEPT = 4  # stretches


class Preview(Trace):
    """A trial by the interpreter, until this process has compiled its `own` trace."""

    def __init__(self, setting: Setting, seed: int, trial: int) -> None:
        """Start compiling in a thread."""
        self.setting, self.seed, self.trial = addresses.in_trial(setting, seed, trial), seed, trial
        self.own: Future[Trace] = Future()
        request = setting, seed, trial, max(1, AT_ONCE // setting.robots)
        self._packed, self._kept = packed(request), OrderedDict[int, Stretch]()
        INTERPRETER.start()
        make = partial(Stepped, *request)
        threading.Thread(target=self._compile, args=(make,), name="swarmcensus", daemon=True).start()
        for name in ("rounds", "labels", "length", "given", "start", "adds"):
            setattr(self, name, self._ask(name))

    @property
    def is_compiled(self) -> bool:  # type: ignore[override]
        """Whether this process computes the trial."""
        return self.own.done()

    def _compile(self, make: Callable[[], Trace]) -> None:
        with INTERPRETER:
            try:
                own = make()
                own.states(0, 2)
                self.own.set_result(own)
            except BaseException as error:
                self.own.set_exception(error)

    def _ask(self, what: str, *given: Any) -> Any:
        """The answer of whoever has it first. What fails in CPython fails here too, with a better message."""
        if not self.own.done():
            answer = INTERPRETER.ask(self._packed, what, given)
            wait((answer, self.own), return_when=FIRST_COMPLETED)
            if answer.done() and (told := answer.result()) is not None:
                return told[0]
        return answer_of(self.own.result(), what, given)

    approach = partialmethod(_ask, "approach")
    read = partialmethod(_ask, "read")
    heard = partialmethod(_ask, "heard")
    hears = partialmethod(_ask, "hears")
    carried = partialmethod(_ask, "carried")
    floor = partialmethod(_ask, "floor")
    truths = partialmethod(_ask, "truths")

    def at(self, k: int) -> Stretch:
        """The k-th stretch, or the start. Raises InputError."""
        if k < 0:
            return self.start
        if k not in self._kept:
            self._kept[k] = self._ask("at", k)
            if len(self._kept) > KEPT:
                self._kept.popitem(last=False)
        return self._kept[k]

    def stretch(self, k: int) -> Stretch | None:
        """The k-th stretch if it is kept, else None."""
        return self._kept.get(k)
