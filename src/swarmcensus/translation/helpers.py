"""Small functions of C for what Python means by min, %, // and round, and for what some C libraries lack."""

from collections.abc import Collection

from swarmcensus.translation.pieces import functions


def of_python(needs: Collection[str], number: str) -> str:
    """The helper functions of these names."""
    suffix = "f" if number == "float" else ""
    # F_ is the suffix of functions of math.h, and of literals
    return "".join(text.replace("F_", suffix) for name, text in functions("helpers.h").items() if name in needs).strip()


def of_avr(called: Collection[str]) -> str:
    """What replaces functions of math.h that avr-libc lacks; empty if none of `called` is among them."""
    lacking = dict(functions("avr.h"))
    lacking["erfc"] = lacking["erf"]
    texts = dict.fromkeys(text for name, text in lacking.items() if name in called)
    if not texts:
        return ""
    lines = ["#ifdef __AVR__  // its library lacks these functions, and its double is a float", *texts]
    used, both = {*called} & {*lacking}, {"erf", "erfc"}  # one text has both
    for name in [*(sorted(both) if used & both else ()), *sorted(used - both)]:
        lines += [f"#define {name}f missing_{name}f", f"#define {name} missing_{name}f"]
    return "\n".join([*lines, "#endif"]).replace("\n\n", "\n")
