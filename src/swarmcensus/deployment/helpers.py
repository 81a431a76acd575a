"""Small functions of C for what Python means by min, %, // and round, and for what some C libraries lack."""

from collections.abc import Collection

# {f} is the suffix of the functions of math.h, and of literals: f for float, nothing for double
OF_PYTHON = {
    "number_min": """
static inline number number_min(number a, number b) { return b < a ? b : a; }""",
    "number_max": """
static inline number number_max(number a, number b) { return b > a ? b : a; }""",
    "number_square": """
static inline number number_square(number x) { return x * x; }""",
    "whole_min": """
static inline int32_t whole_min(int32_t a, int32_t b) { return b < a ? b : a; }""",
    "whole_max": """
static inline int32_t whole_max(int32_t a, int32_t b) { return b > a ? b : a; }""",
    "whole_abs": """
static inline int32_t whole_abs(int32_t a) { return a < 0 ? -a : a; }""",
    "to_whole": """
// Cuts off the fraction. A number beyond 32 bits becomes the nearest that has them; one that is no number becomes 0.
static inline int32_t to_whole(number x) {
    if (x >= 2147483648.0{f}) {
        return INT32_MAX;
    }
    if (x <= -2147483648.0{f}) {
        return INT32_MIN;
    }
    return x == x ? (int32_t)x : 0;
}""",
    "nearest_even": """
// The nearest whole number, of two equally near the even one.
static inline number nearest_even(number x) {
    const number low = floor{f}(x);
    const number rest = x - low;
    if (rest > 0.5{f} || (rest == 0.5{f} && fmod{f}(low, 2.0{f}) != 0.0{f})) {
        return low + 1.0{f};
    }
    return low;
}""",
    "number_modulo": """
// The remainder has the sign of the divisor.
static inline number number_modulo(number a, number b) {
    const number rest = fmod{f}(a, b);
    if (rest == 0.0{f}) {
        return copysign{f}(0.0{f}, b);
    }
    return (rest < 0.0{f}) != (b < 0.0{f}) ? rest + b : rest;
}""",
    "number_floor_divide": """
// The quotient, rounded down.
static inline number number_floor_divide(number a, number b) {
    const number rest = fmod{f}(a, b);
    number quotient = (a - rest) / b;
    if (rest != 0.0{f} && (rest < 0.0{f}) != (b < 0.0{f})) {
        quotient -= 1.0{f};
    }
    const number low = floor{f}(quotient);
    return quotient - low > 0.5{f} ? low + 1.0{f} : low;
}""",
    "whole_modulo": """
// The remainder has the sign of the divisor; of 0 it is 0.
static inline int32_t whole_modulo(int32_t a, int32_t b) {
    const int32_t rest = b == 0 || b == -1 ? 0 : a % b;
    return rest != 0 && (rest < 0) != (b < 0) ? rest + b : rest;
}""",
    "whole_product_modulo": """
// The remainder of a product, which may have more than 32 bits.
static inline int32_t whole_product_modulo(int32_t a, int32_t b, int32_t modulus) {
    const int32_t rest = modulus == 0 ? 0 : (int32_t)((int64_t)a * b % modulus);
    return rest != 0 && (rest < 0) != (modulus < 0) ? rest + modulus : rest;
}""",
    "whole_floor_divide": """
// The quotient, rounded down; by 0 it is 0.
static inline int32_t whole_floor_divide(int32_t a, int32_t b) {
    if (b == 0) {
        return 0;
    }
    if (b == -1) {
        return -a;
    }
    return a / b - (a % b != 0 && (a < 0) != (b < 0));
}""",
    "whole_power": """
static inline int32_t whole_power(int32_t base, int32_t exponent) {
    int32_t power = 1;
    while (exponent-- > 0) {
        power *= base;
    }
    return power;
}""",
    "item_at": """
// The place of an item; a negative index counts from the end, and one beyond the end is that of the last item.
static inline int32_t item_at(int32_t index, int32_t items) {
    const int32_t place = index < 0 ? index + items : index;
    return place < items ? place : items - 1;
}""",
}
# avr-libc has no such functions, and its numbers are floats
OF_AVR = {
    "expm1": """
static inline float missing_expm1f(float x) {
    if (fabsf(x) < 0.01f) {
        return x * (1.0f + x * (0.5f + x * (0.16666667f + x * 0.041666668f)));
    }
    return expf(x) - 1.0f;
}""",
    "log2": """
static inline float missing_log2f(float x) { return logf(x) * 1.442695f; }""",
    "erf": """
// A power series near 0, and the continued fraction of the rest beyond.
static inline float missing_erfcf(float x) {
    const float size = fabsf(x);
    const float square = x * x;
    if (size < 2.0f) {
        float term = x;
        float sum = x;
        for (int8_t n = 1; n < 40; n++) {
            term *= -square / n;
            sum += term / (2 * n + 1);
        }
        return 1.0f - 1.1283792f * sum;
    }
    float tail = 0.0f;
    for (int8_t n = 24; n > 0; n--) {
        tail = 0.5f * n / (size + tail);
    }
    const float rest = square > 87.0f ? 0.0f : expf(-square) * 0.5641896f / (size + tail);
    return x < 0.0f ? 2.0f - rest : rest;
}
static inline float missing_erff(float x) {
    if (fabsf(x) < 0.001f) {
        return 1.1283792f * x;
    }
    return 1.0f - missing_erfcf(x);
}""",
    "lgamma": """
// Stirling's formula, after steps up to where it is exact in float.
static inline float missing_lgammaf(float x) {
    float product = 1.0f;
    while (x < 8.0f) {
        product *= x;
        x += 1.0f;
    }
    const float square = 1.0f / (x * x);
    const float rest = (0.083333336f - square * (0.0027777778f - square * 0.0007936508f)) / x;
    return (x - 0.5f) * logf(x) - x + 0.9189385f + rest - logf(fabsf(product));
}""",
}
OF_AVR["erfc"] = OF_AVR["erf"]


def of_python(needs: Collection[str], number: str) -> str:
    """The helper functions of these names."""
    suffix = "f" if number == "float" else ""
    return "".join(text.replace("{f}", suffix) for name, text in OF_PYTHON.items() if name in needs).strip()


def of_avr(functions: Collection[str]) -> str:
    """What replaces functions of math.h that avr-libc lacks; empty if none of `functions` is among them."""
    texts = dict.fromkeys(OF_AVR[name] for name in OF_AVR if name in functions)
    if not texts:
        return ""
    lines = ["#ifdef __AVR__  // its library lacks these functions, and its double is a float", *texts]
    for name in sorted({"erf", "erfc"} if {"erf", "erfc"} & set(functions) else ()) + sorted(
        set(functions) & set(OF_AVR) - {"erf", "erfc"}
    ):
        lines += [f"#define {name}f missing_{name}f", f"#define {name} missing_{name}f"]
    return "\n".join([*lines, "#endif"]).replace("\n\n", "\n")
