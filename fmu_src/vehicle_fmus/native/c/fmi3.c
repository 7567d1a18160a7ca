/* FMI 3.0 for co-simulation, on an instance (core.c). */

#include "fmi3Functions.h"

/* Value references after those of the variables: time, and two clocks for each tyre. */
#define TIME VARIABLES
#define FIRST_CLOCK (VARIABLES + 1)
#define CLOCKS (2 * TYRES)
/* of messages; no call is discarded: after a step that failed, the instance is not what it was before */
#define CATEGORIES 3

typedef struct Host {
    Instance instance;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    fmi3IntermediateUpdateCallback update;
} Host;

static void tell(Instance *one, int status, const char *category, const char *text) {
    Host *host = one->host;
    if (host->log) host->log(host->environment, (fmi3Status) status, category, text);
}

static fmi3Status failed(Host *host) {
    if (host->log) {
        host->log(host->environment, fmi3Error, "logStatusError", host->instance.reason);
    }
    return fmi3Error;
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t count,
        const fmi3String categories[]) {
    Host *host = c;
    return switch_logging(&host->instance, on, count, categories, CATEGORIES) ? failed(host) : fmi3OK;
}

/* ---- life ---------------------------------------------------------------------------------- */

/* Let the host look at an instant within its step; return where it wants the step to end. */
static double let_look(Instance *one, double time) {
    Host *host = one->host;
    fmi3Boolean wanted = fmi3False;
    fmi3Float64 end = INFINITY;
    one->now.mode = LOOKING;
    host->update(host->environment, time, fmi3False, fmi3True, fmi3True, one->early_return, &wanted, &end);
    one->now.mode = STEP;
    return wanted && one->early_return ? end : INFINITY;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
        fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
        const fmi3ValueReference required[], size_t count, fmi3InstanceEnvironment environment,
        fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    Host *host;
    (void) name, (void) resources, (void) visible, (void) required, (void) count;
    if (!token || strcmp(token, GUID) != 0) {
        if (log) {
            log(environment, fmi3Error, "logStatusError",
                    "the instantiation token is not that of the model description");
        }
        return NULL;
    }
    host = calloc(1, sizeof *host);
    if (!host) return NULL;
    host->environment = environment;
    host->log = log;
    host->update = update;
    switch_logging(&host->instance, logging, 0, NULL, CATEGORIES);
    host->instance.host = host;
    host->instance.event_mode = event_mode;
    host->instance.early_return = early_return;
    host->instance.update = update ? let_look : NULL;
    reset_instance(&host->instance);
    return host;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
        fmi3Boolean visible, fmi3Boolean logging, fmi3InstanceEnvironment environment,
        fmi3LogMessageCallback log) {
    (void) name, (void) token, (void) resources, (void) visible, (void) logging;
    if (log) log(environment, fmi3Error, "logStatusError", "this FMU is for co-simulation only");
    return NULL;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
        fmi3Boolean visible, fmi3Boolean logging, fmi3InstanceEnvironment environment,
        fmi3LogMessageCallback log, fmi3ClockUpdateCallback clock, fmi3LockPreemptionCallback lock,
        fmi3UnlockPreemptionCallback unlock) {
    (void) clock, (void) lock, (void) unlock;
    return fmi3InstantiateModelExchange(name, token, resources, visible, logging, environment, log);
}

void fmi3FreeInstance(fmi3Instance c) { free(c); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
        fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop) {
    Host *host = c;
    State *now = &host->instance.now;
    if (misplaced(&host->instance, "fmi3EnterInitializationMode", INSTANTIATED)) return failed(host);
    now->start = start;
    now->end = has_stop ? stop : -UNBOUNDED;
    now->tolerance = has_tolerance ? tolerance : 0.0;
    now->ready = 0;
    now->mode = INITIALIZATION;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    Host *host = c;
    Instance *one = &host->instance;
    if (misplaced(one, "fmi3ExitInitializationMode", INITIALIZATION)) return failed(host);
    return end_initialisation(one) ? failed(host) : fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance c) {
    Host *host = c;
    if (misplaced(&host->instance, "fmi3Terminate", EVENT | STEP)) return failed(host);
    host->instance.now.mode = TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance c) {
    Host *host = c;
    if (misplaced(&host->instance, "fmi3Reset", ~LOOKING)) return failed(host);
    reset_instance(&host->instance);
    return fmi3OK;
}

/* ---- variables ----------------------------------------------------------------------------- */

static int have_room(Host *host, size_t count, size_t values) {
    if (count == values) return 1;
    fail(&host->instance, "%lu values for %lu scalar variables", (unsigned long) values,
            (unsigned long) count);
    return 0;
}

static int is_readable(Host *host, fmi3ValueReference k, int kind) {
    return (kind == REAL && k == TIME) || is_of_kind(&host->instance, k, kind);
}

static double value_of(Host *host, fmi3ValueReference k) {
    const State *now = &host->instance.now;
    if (k == TIME) return is_initialised(now) ? now->conduct.run.time : now->start;
    return get_value(&host->instance, k);
}

#define GET(Name, KIND, VALUE)                                                                      \
    fmi3Status fmi3Get##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t count,           \
            fmi3##Name value[], size_t values) {                                                    \
        Host *host = c;                                                                             \
        if (!have_room(host, count, values)) return failed(host);                                   \
        for (size_t k = 0; k < count; k++) {                                                        \
            if (!is_readable(host, vr[k], KIND)) return failed(host);                               \
            value[k] = VALUE;                                                                       \
        }                                                                                           \
        return fmi3OK;                                                                              \
    }

#define SET(Name, KIND, set)                                                                        \
    fmi3Status fmi3Set##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t count,           \
            const fmi3##Name value[], size_t values) {                                              \
        Host *host = c;                                                                             \
        if (!have_room(host, count, values)) return failed(host);                                   \
        if (misplaced(&host->instance, "fmi3Set" #Name,                                             \
                    INSTANTIATED | INITIALIZATION | EVENT | STEP)) {                                \
            return failed(host);                                                                    \
        }                                                                                           \
        for (size_t k = 0; k < count; k++) {                                                        \
            if (!is_of_kind(&host->instance, vr[k], KIND) ||                                        \
                set(&host->instance, vr[k], value[k])) {                                            \
                return failed(host);                                                                \
            }                                                                                       \
        }                                                                                           \
        return fmi3OK;                                                                              \
    }

GET(Float64, REAL, value_of(host, vr[k]))
GET(Int32, INTEGER, value_of(host, vr[k]))
GET(Boolean, BOOLEAN, value_of(host, vr[k]) != 0.0)
GET(String, STRING, variables[vr[k]].text)
SET(Float64, REAL, set_value)
SET(Int32, INTEGER, set_value)
SET(Boolean, BOOLEAN, set_value)
SET(String, STRING, set_text)

fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
        fmi3Clock value[]) {
    Host *host = c;
    for (size_t k = 0; k < count; k++) {
        if (vr[k] < FIRST_CLOCK || vr[k] >= FIRST_CLOCK + CLOCKS) {
            fail(&host->instance, "value reference %u is no clock", vr[k]);
            return failed(host);
        }
        value[k] = host->instance.now.mode == EVENT && host->instance.now.ticks[vr[k] - FIRST_CLOCK];
    }
    return fmi3OK;
}

/* ---- steps and events ---------------------------------------------------------------------- */

fmi3Status fmi3EnterStepMode(fmi3Instance c) {
    Host *host = c;
    if (misplaced(&host->instance, "fmi3EnterStepMode", EVENT)) return failed(host);
    host->instance.now.mode = STEP;
    return fmi3OK;
}

fmi3Status fmi3EnterEventMode(fmi3Instance c) {
    Host *host = c;
    Instance *one = &host->instance;
    if (!one->event_mode) {
        fail(one, "this instance was made without event mode");
        return failed(host);
    }
    if (misplaced(one, "fmi3EnterEventMode", STEP)) return failed(host);
    come_to(one, one->now.conduct.run.time);
    host->instance.now.mode = EVENT;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *terminate,
        fmi3Boolean *nominals_changed, fmi3Boolean *values_changed, fmi3Boolean *has_next,
        fmi3Float64 *next) {
    Host *host = c;
    State *now = &host->instance.now;
    double corner;
    if (misplaced(&host->instance, "fmi3UpdateDiscreteStates", EVENT)) return failed(host);
    memset(now->ticks, 0, sizeof now->ticks);
    corner = Network_next_corner(now->machine.integrator.net, now->conduct.run.time);
    host->instance.roads_known = 0;
    *again = *terminate = *nominals_changed = *values_changed = fmi3False;
    *has_next = corner < UNBOUNDED;
    *next = corner;
    return fmi3OK;
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) {
    (void) c;
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 size, fmi3Boolean no_return,
        fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    Host *host = c;
    Instance *one = &host->instance;
    const double until = time + size;
    int status = 1;
    (void) no_return;
    *event = *terminate = *early = fmi3False;
    if (!misplaced(one, "fmi3DoStep", STEP)) status = make_step(one, time, size);
    *reached = one->now.conduct.run.time;
    if (status) return failed(host);
    *event = one->event_mode && one->now.switched;
    *early = *reached < until;
    return fmi3OK;
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
        const fmi3Int32 order[], fmi3Float64 value[], size_t values) {
    Host *host = c;
    if (!have_room(host, count, values)) return failed(host);
    for (size_t k = 0; k < count; k++) {
        if (find_rate(&host->instance, vr[k], order[k], &value[k])) return failed(host);
    }
    return fmi3OK;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknown[],
        size_t unknowns, const fmi3ValueReference known[], size_t knowns, const fmi3Float64 seed[],
        size_t seeds, fmi3Float64 sensitivity[], size_t sensitivities) {
    Host *host = c;
    if (misplaced(&host->instance, "fmi3GetDirectionalDerivative", ~INSTANTIATED) ||
        !have_room(host, knowns, seeds) || !have_room(host, unknowns, sensitivities)) {
        return failed(host);
    }
    if (find_sensitivity(&host->instance, unknown, unknowns, known, knowns, seed, sensitivity)) {
        return failed(host);
    }
    return fmi3OK;
}

/* ---- whole state --------------------------------------------------------------------------- */

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) {
    Host *host = c;
    if (misplaced(&host->instance, "fmi3GetFMUState", ~LOOKING)) return failed(host);
    return copy_state(&host->instance, (State **) state) ? failed(host) : fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
    Host *host = c;
    if (misplaced(&host->instance, "fmi3SetFMUState", ~LOOKING)) return failed(host);
    return restore(&host->instance, state) ? failed(host) : fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) {
    (void) c;
    free_state(state);
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
    (void) c, (void) state;
    *size = SERIALIZED;
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    Host *host = c;
    return write_state(&host->instance, bytes, size, state) ? failed(host) : fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size,
        fmi3FMUState *state) {
    Host *host = c;
    return read_state(&host->instance, bytes, size, (State **) state) ? failed(host) : fmi3OK;
}

/* ---- what it does not have ----------------------------------------------------------------- */

static fmi3Status missing(fmi3Instance c, const char *what) {
    fail(&((Host *) c)->instance, "this FMU has no %s", what);
    return failed(c);
}

#define NO_TYPE(Name)                                                                               \
    fmi3Status fmi3Get##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t count,           \
            fmi3##Name value[], size_t values) {                                                    \
        (void) vr, (void) count, (void) value, (void) values;                                       \
        return count ? missing(c, "variables of type " #Name) : fmi3OK;                             \
    }                                                                                               \
    fmi3Status fmi3Set##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t count,           \
            const fmi3##Name value[], size_t values) {                                              \
        (void) vr, (void) count, (void) value, (void) values;                                       \
        return count ? missing(c, "variables of type " #Name) : fmi3OK;                             \
    }

NO_TYPE(Float32)
NO_TYPE(Int8)
NO_TYPE(UInt8)
NO_TYPE(Int16)
NO_TYPE(UInt16)
NO_TYPE(UInt32)
NO_TYPE(Int64)
NO_TYPE(UInt64)

/* Functions that belong to what this FMU is not. */
#define NO_FUNCTION(Name, what, ...)                                                                \
    fmi3Status Name(fmi3Instance c, __VA_ARGS__) { return missing(c, what); }

#define REFERENCES const fmi3ValueReference vr[], size_t count
#define SENSITIVITIES                                                                               \
    const fmi3ValueReference unknowns[], size_t n_unknowns, const fmi3ValueReference knowns[],      \
            size_t n_knowns, const fmi3Float64 seed[], size_t n_seed, fmi3Float64 sensitivity[],    \
            size_t n_sensitivity

NO_FUNCTION(fmi3GetBinary, "binary variables", REFERENCES, size_t sizes[], fmi3Binary value[], size_t n)
NO_FUNCTION(fmi3SetBinary, "binary variables", REFERENCES, const size_t sizes[],
        const fmi3Binary value[], size_t n)
NO_FUNCTION(fmi3SetClock, "input clocks", REFERENCES, const fmi3Clock value[])
NO_FUNCTION(fmi3GetNumberOfVariableDependencies, "dependencies that change", fmi3ValueReference vr,
        size_t *count)
NO_FUNCTION(fmi3GetVariableDependencies, "dependencies that change", fmi3ValueReference vr, size_t a[],
        fmi3ValueReference b[], size_t d[], fmi3DependencyKind kind[], size_t count)
NO_FUNCTION(fmi3GetAdjointDerivative, "adjoint derivatives", SENSITIVITIES)
NO_FUNCTION(fmi3GetIntervalDecimal, "clocks with intervals", REFERENCES, fmi3Float64 interval[],
        fmi3IntervalQualifier qualifier[])
NO_FUNCTION(fmi3GetIntervalFraction, "clocks with intervals", REFERENCES, fmi3UInt64 counter[],
        fmi3UInt64 resolution[], fmi3IntervalQualifier qualifier[])
NO_FUNCTION(fmi3GetShiftDecimal, "clocks with intervals", REFERENCES, fmi3Float64 shift[])
NO_FUNCTION(fmi3GetShiftFraction, "clocks with intervals", REFERENCES, fmi3UInt64 counter[],
        fmi3UInt64 resolution[])
NO_FUNCTION(fmi3SetIntervalDecimal, "clocks with intervals", REFERENCES, const fmi3Float64 interval[])
NO_FUNCTION(fmi3SetIntervalFraction, "clocks with intervals", REFERENCES, const fmi3UInt64 counter[],
        const fmi3UInt64 resolution[])
NO_FUNCTION(fmi3SetShiftDecimal, "clocks with intervals", REFERENCES, const fmi3Float64 shift[])
NO_FUNCTION(fmi3SetShiftFraction, "clocks with intervals", REFERENCES, const fmi3UInt64 counter[],
        const fmi3UInt64 resolution[])
NO_FUNCTION(fmi3ActivateModelPartition, "model partitions", fmi3ValueReference clock, fmi3Float64 time)
NO_FUNCTION(fmi3CompletedIntegratorStep, "model exchange", fmi3Boolean no_return, fmi3Boolean *enter,
        fmi3Boolean *terminate)
NO_FUNCTION(fmi3SetTime, "model exchange", fmi3Float64 time)
NO_FUNCTION(fmi3SetContinuousStates, "model exchange", const fmi3Float64 x[], size_t count)
NO_FUNCTION(fmi3GetContinuousStateDerivatives, "model exchange", fmi3Float64 x[], size_t count)
NO_FUNCTION(fmi3GetEventIndicators, "model exchange", fmi3Float64 x[], size_t count)
NO_FUNCTION(fmi3GetContinuousStates, "model exchange", fmi3Float64 x[], size_t count)
NO_FUNCTION(fmi3GetNominalsOfContinuousStates, "model exchange", fmi3Float64 x[], size_t count)
NO_FUNCTION(fmi3GetNumberOfEventIndicators, "model exchange", size_t *count)
NO_FUNCTION(fmi3GetNumberOfContinuousStates, "model exchange", size_t *count)

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) { return missing(c, "model exchange"); }
fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { return missing(c, "structural parameters"); }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { return missing(c, "structural parameters"); }
