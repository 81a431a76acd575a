"""Names that a translated brain must not define: words of C and C++, of their libraries, and of our own files."""

import re

# the beginnings of macros of the C library, and of what brain.h defines besides the brain
OURS = re.compile(
    r"(U?INT(8|16|32|64|MAX|PTR|_)|SIZE_|PTRDIFF_|SIG_|WCHAR_|WINT_|FLT_|DBL_|LDBL_|FP_|HUGE_|MATH_|M_|BRAIN_"
    r"|brain_|parameter_|constant_|helper_|codec_|missing_|test_|cost_|robot_|kilo_)"
)
WORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int long register
restrict return short signed sizeof static struct switch typedef union unsigned void volatile while _Bool _Complex
alignas alignof and and_eq asm bitand bitor bool catch class compl constexpr const_cast decltype delete dynamic_cast
explicit export false friend mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected
public reinterpret_cast static_assert static_cast template this thread_local throw true try typeid typename using
virtual char8_t char16_t char32_t wchar_t xor xor_eq
concept requires consteval constinit co_await co_return co_yield
""".split()  # noqa: SIM905 - read more easily than a list
MATH = """
acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs fdim floor fma fmax fmin
fmod frexp hypot ilogb ldexp lgamma llrint llround log log10 log1p log2 logb lrint lround modf nan nearbyint nextafter
nexttoward pow remainder remquo rint round scalbln scalbn sin sinh sqrt tan tanh tgamma trunc gamma drem significand
exp10 pow10 sincos j0 j1 jn y0 y1 yn
""".split()  # noqa: SIM905 - read more easily than a list
OWN = """
number number_min number_max number_square whole_min whole_max number_modulo whole_modulo whole_product_modulo
number_floor_divide whole_floor_divide whole_power whole_abs to_whole nearest_even item_at split_number
""".split()  # noqa: SIM905 - read more easily than a list
MACROS = """
NAN INFINITY NULL EOF errno assert M_PI M_E MAXFLOAT SNAN SNANF SNANL RAND_MAX EXIT_SUCCESS EXIT_FAILURE MB_CUR_MAX
BUFSIZ SEEK_SET SEEK_CUR SEEK_END SEEK_DATA SEEK_HOLE TMP_MAX L_tmpnam L_ctermid P_tmpdir FILENAME_MAX FOPEN_MAX stdin
stdout stderr WNOHANG WUNTRACED WCONTINUED WEXITED WSTOPPED WNOWAIT BYTE_ORDER LITTLE_ENDIAN BIG_ENDIAN PDP_ENDIAN
FD_SETSIZE NFDBITS typeof linux unix i386 AVR
""".split()  # noqa: SIM905 - read more easily than a list
OF_FIELDS = frozenset([*WORDS, *MACROS, "number", "owed"])
TYPES = [f"{sign}int{bits}_t" for sign in ("", "u") for bits in (8, 16, 32, 64)] + ["size_t"]
OF_LOCALS = OF_FIELDS.union(TYPES, MATH, (f"{name}f" for name in MATH), OWN, ("main", "isnan", "isinf", "isfinite"))
