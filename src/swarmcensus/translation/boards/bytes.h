//: codec_put_16
static inline void codec_put_16(uint8_t *out, uint16_t code) {
    out[0] = (uint8_t)(code & 255);
    out[1] = (uint8_t)(code >> 8);
}
//: codec_get_16
static inline uint16_t codec_get_16(const uint8_t *bytes) { return (uint16_t)(bytes[0] | bytes[1] << 8); }
//: codec_put_float
static inline void codec_put_float(uint8_t *out, number x) {
    union {
        float value;
        uint32_t bits;
    } both;
    both.value = CLAMPED;
    for (uint8_t k = 0; k < 4; k++) {
        out[k] = (uint8_t)(both.bits >> 8 * k & 255);
    }
}
//: codec_get_float
static inline number codec_get_float(const uint8_t *bytes) {
    union {
        float value;
        uint32_t bits;
    } both;
    both.bits = 0;
    for (uint8_t k = 0; k < 4; k++) {
        both.bits |= (uint32_t)bytes[k] << 8 * k;
    }
    return both.value;
}
