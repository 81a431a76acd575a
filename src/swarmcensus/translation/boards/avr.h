//: expm1
static inline float missing_expm1f(float x) {
    if (fabsf(x) < 0.01f) {
        return x * (1.0f + x * (0.5f + x * (0.16666667f + x * 0.041666668f)));
    }
    return expf(x) - 1.0f;
}
//: log2
static inline float missing_log2f(float x) { return logf(x) * 1.442695f; }
//: erf
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
}
//: lgamma
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
}
