/* One variable of the model, and what an instance says to its host. */

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REAL, INTEGER, BOOLEAN, STRING };
enum { PARAMETER, INPUT, OUTPUT };

typedef struct Variable {
    const char *name;
    int kind, causality, tunable, positive;
    double start, minimum, maximum, nominal;
    const char *range; /* the allowed values, in words */
    const char *text;  /* the start of a string; of an input, why it has no effect if it has none */
    int index;         /* number of an input among the inputs */
} Variable;
