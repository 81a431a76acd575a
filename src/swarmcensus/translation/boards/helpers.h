//: number_min
static inline number number_min(number a, number b) { return b < a ? b : a; }
//: number_max
static inline number number_max(number a, number b) { return b > a ? b : a; }
//: number_square
static inline number number_square(number x) { return x * x; }
//: whole_min
static inline int32_t whole_min(int32_t a, int32_t b) { return b < a ? b : a; }
//: whole_max
static inline int32_t whole_max(int32_t a, int32_t b) { return b > a ? b : a; }
//: whole_abs
static inline int32_t whole_abs(int32_t a) { return a < 0 ? -a : a; }
//: to_whole
// Cuts off the fraction. A number beyond 32 bits becomes the nearest that has them; one that is no number becomes 0.
static inline int32_t to_whole(number x) {
    if (x >= 2147483648.0F_) {
        return INT32_MAX;
    }
    if (x <= -2147483648.0F_) {
        return INT32_MIN;
    }
    return x == x ? (int32_t)x : 0;
}
//: nearest_even
// The nearest whole number, of two equally near the even one.
static inline number nearest_even(number x) {
    const number low = floorF_(x);
    const number rest = x - low;
    if (rest > 0.5F_ || (rest == 0.5F_ && fmodF_(low, 2.0F_) != 0.0F_)) {
        return low + 1.0F_;
    }
    return low;
}
//: number_modulo
// The remainder has the sign of the divisor.
static inline number number_modulo(number a, number b) {
    const number rest = fmodF_(a, b);
    if (rest == 0.0F_) {
        return copysignF_(0.0F_, b);
    }
    return (rest < 0.0F_) != (b < 0.0F_) ? rest + b : rest;
}
//: number_floor_divide
// The quotient, rounded down.
static inline number number_floor_divide(number a, number b) {
    const number rest = fmodF_(a, b);
    number quotient = (a - rest) / b;
    if (rest != 0.0F_ && (rest < 0.0F_) != (b < 0.0F_)) {
        quotient -= 1.0F_;
    }
    if (quotient == 0.0F_) {
        return copysignF_(0.0F_, a / b);
    }
    const number low = floorF_(quotient);
    return quotient - low > 0.5F_ ? low + 1.0F_ : low;
}
//: whole_modulo
// The remainder has the sign of the divisor; of 0 it is 0.
static inline int32_t whole_modulo(int32_t a, int32_t b) {
    const int32_t rest = b == 0 || b == -1 ? 0 : a % b;
    return rest != 0 && (rest < 0) != (b < 0) ? rest + b : rest;
}
//: whole_product_modulo
// The remainder of a product, which may have more than 32 bits.
static inline int32_t whole_product_modulo(int32_t a, int32_t b, int32_t modulus) {
    const int32_t rest = modulus == 0 ? 0 : (int32_t)((int64_t)a * b % modulus);
    return rest != 0 && (rest < 0) != (modulus < 0) ? rest + modulus : rest;
}
//: whole_floor_divide
// The quotient, rounded down; by 0 it is 0.
static inline int32_t whole_floor_divide(int32_t a, int32_t b) {
    if (b == 0) {
        return 0;
    }
    if (b == -1) {
        return -a;
    }
    return a / b - (a % b != 0 && (a < 0) != (b < 0));
}
//: whole_power
static inline int32_t whole_power(int32_t base, int32_t exponent) {
    int32_t power = 1;
    while (exponent-- > 0) {
        power *= base;
    }
    return power;
}
//: item_at
// The place of an item; a negative index counts from the end, and one beyond the end is that of the last item.
static inline int32_t item_at(int32_t index, int32_t items) {
    const int32_t place = index < 0 ? index + items : index;
    return place < items ? place : items - 1;
}
