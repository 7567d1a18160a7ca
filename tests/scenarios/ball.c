/* A ball that bounces without loss, for model exchange in FMI 2.0: h'' = -9.81 m/s2, h > 0. */

#include <stdlib.h>

#include "fmi2Functions.h"

typedef struct Ball {
    double x[2], time;
    const fmi2CallbackFunctions *host;
} Ball;

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

static void drop(Ball *ball) {
    ball->x[0] = 1.0;
    ball->x[1] = 0.0;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
        const fmi2CallbackFunctions *host, fmi2Boolean visible, fmi2Boolean logging) {
    Ball *ball = calloc(1, sizeof *ball);
    if (type != fmi2ModelExchange) return NULL;
    ball->host = host;
    drop(ball);
    return ball;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2Reset(fmi2Component c) { drop(c); return fmi2OK; }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    for (size_t k = 0; k < n; k++) value[k] = vr[k] < 2 ? ((Ball *) c)->x[vr[k]] : -9.81;
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    for (size_t k = 0; k < n; k++) {
        if (vr[k] != 0 || value[k] <= 0.0) {
            const Ball *ball = c;
            ball->host->logger(ball->host->componentEnvironment, "ball", fmi2Error, "logStatusError",
                    "the height must be greater than 0");
            return fmi2Error;
        }
        ((Ball *) c)->x[0] = value[k];
    }
    return fmi2OK;
}
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    Ball *ball = c;
    info->newDiscreteStatesNeeded = info->terminateSimulation = fmi2False;
    info->nominalsOfContinuousStatesChanged = info->nextEventTimeDefined = fmi2False;
    info->valuesOfContinuousStatesChanged = ball->x[0] <= 0.0 && ball->x[1] < 0.0;
    if (info->valuesOfContinuousStatesChanged) {
        ball->x[0] = 1e-300;
        ball->x[1] = -ball->x[1];
    }
    return fmi2OK;
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean last, fmi2Boolean *event,
        fmi2Boolean *over) {
    *event = *over = fmi2False;
    return fmi2OK;
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) {
    dx[0] = ((Ball *) c)->x[1];
    dx[1] = -9.81;
    return fmi2OK;
}
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n) {
    z[0] = ((Ball *) c)->x[0];
    return fmi2OK;
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    x[0] = ((Ball *) c)->x[0];
    x[1] = ((Ball *) c)->x[1];
    return fmi2OK;
}
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    ((Ball *) c)->x[0] = x[0];
    ((Ball *) c)->x[1] = x[1];
    return fmi2OK;
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    x[0] = x[1] = 1.0;
    return fmi2OK;
}

#define DONE(name, ...) fmi2Status name(fmi2Component c, ##__VA_ARGS__) { return fmi2OK; }
#define NONE(name, ...) fmi2Status name(fmi2Component c, ##__VA_ARGS__) { return fmi2Error; }
#define VR const fmi2ValueReference vr[], size_t n

DONE(fmi2SetDebugLogging, fmi2Boolean on, size_t n, const fmi2String categories[])
DONE(fmi2SetupExperiment, fmi2Boolean a, fmi2Real b, fmi2Real start, fmi2Boolean d, fmi2Real stop)
DONE(fmi2EnterInitializationMode)
DONE(fmi2ExitInitializationMode)
DONE(fmi2Terminate)
DONE(fmi2EnterEventMode)
DONE(fmi2EnterContinuousTimeMode)
DONE(fmi2SetTime, fmi2Real time)
NONE(fmi2GetInteger, VR, fmi2Integer value[])
NONE(fmi2GetBoolean, VR, fmi2Boolean value[])
NONE(fmi2GetString, VR, fmi2String value[])
NONE(fmi2SetInteger, VR, const fmi2Integer value[])
NONE(fmi2SetBoolean, VR, const fmi2Boolean value[])
NONE(fmi2SetString, VR, const fmi2String value[])
NONE(fmi2GetFMUstate, fmi2FMUstate *state)
NONE(fmi2SetFMUstate, fmi2FMUstate state)
NONE(fmi2FreeFMUstate, fmi2FMUstate *state)
NONE(fmi2SerializedFMUstateSize, fmi2FMUstate state, size_t *size)
NONE(fmi2SerializeFMUstate, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
NONE(fmi2DeSerializeFMUstate, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
NONE(fmi2GetDirectionalDerivative, VR, const fmi2ValueReference known[], size_t m, const fmi2Real a[],
        fmi2Real b[])
