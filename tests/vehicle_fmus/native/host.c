/* A host of one native FMU: runs it, returns to a state, sets what it cannot have; built with sanitizers. */

#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"

static void logger(fmi2ComponentEnvironment host, fmi2String name, fmi2Status status,
        fmi2String category, fmi2String message, ...) {
    (void) host, (void) name, (void) status, (void) category, (void) message;
}

int main(int count, char **arguments) {
    const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};
    const fmi2ValueReference mass = 0, first = (fmi2ValueReference) atoi(arguments[2]);
    fmi2Real wrong = -5.0, before, after;
    fmi2FMUstate state = NULL;
    fmi2Component one = NULL;
    if (count != 3) return 1;
    for (int cycle = 0; cycle < 3; cycle++) {
        if (one) fmi2FreeInstance(one);
        one = fmi2Instantiate("one", fmi2CoSimulation, arguments[1], "", &callbacks, 0, 1);
        if (!one) return 2;
        fmi2SetupExperiment(one, 0, 0.0, 0.0, 0, 0.0);
        fmi2EnterInitializationMode(one);
        if (cycle == 1) fmi2SetReal(one, &mass, 1, &wrong);
        if ((fmi2ExitInitializationMode(one) == fmi2OK) == (cycle == 1)) return 3;
    }
    for (int k = 0; k < 1000; k++) {
        if (k == 300 && fmi2GetFMUstate(one, &state) != fmi2OK) return 4;
        if (fmi2DoStep(one, k * 1e-3, 1e-3, 1) != fmi2OK) return 5;
    }
    fmi2GetReal(one, &first, 1, &before);
    fmi2SetFMUstate(one, state);
    for (int k = 300; k < 1000; k++) fmi2DoStep(one, k * 1e-3, 1e-3, 1);
    fmi2GetReal(one, &first, 1, &after);
    fmi2FreeFMUstate(one, &state);
    fmi2FreeInstance(one);
    return before == after ? 0 : 6;
}
