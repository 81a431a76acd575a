// close WANTED FOUND MOST: whether the numbers in two outputs of a self-test differ by MOST at most, relative above 1.
// The bytes of a message may differ, because they change with the last bit of a number.

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// The number that has these bits; infinite if a word is none.
static double number_in(const char *word) {
    const uint64_t bits = strtoull(word, 0, 16);
    const uint32_t low = (uint32_t)bits;
    double x;
    float single;
    memcpy(&x, &bits, sizeof x);
    memcpy(&single, &low, sizeof single);
    return strlen(word) == 16 ? x : strlen(word) == 8 ? single : INFINITY;
}

static double apart(const char *one, const char *other) {
    const double x = number_in(one), y = number_in(other), rest = fabs(x - y) / fmax(1, fabs(x));
    return strcmp(one, other) == 0 ? 0 : rest < INFINITY ? rest : INFINITY;
}

int main(int count, char **given) {
    FILE *wanted = count == 4 ? fopen(given[1], "r") : 0, *found = count == 4 ? fopen(given[2], "r") : 0;
    if (!wanted || !found) {
        fprintf(stderr, "usage: close WANTED FOUND MOST\n");
        return 2;
    }
    char one[1024], other[1024];
    double largest = 0;
    bool is_memory = false;  // this line has no message
    for (;;) {
        const int words = fscanf(wanted, "%1023s", one);
        if (fscanf(found, "%1023s", other) != words) {
            largest = INFINITY;  // one ends before the other
        }
        if (words != 1 || largest == INFINITY) {
            break;
        }
        const int end = getc(wanted);
        const bool speaks = strcmp(one, "silent") && strcmp(other, "silent");
        if (getc(found) != end) {
            largest = INFINITY;
        } else if (end != '\n' || is_memory || !speaks) {
            largest = fmax(largest, apart(one, other));
        }
        is_memory = end != '\n' && (is_memory || !strcmp(one, "memory"));
    }
    const bool is_close = largest <= atof(given[3]);
    printf("numbers differ by %.2g at most, relative above 1: ", largest);
    printf(is_close ? "what the library of C rounds otherwise\n" : "not what Python has\n");
    return !is_close;
}
