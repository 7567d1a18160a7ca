/* FMI 2.0 for co-simulation, on an instance (core.c). */

#include "fmi2Functions.h"

#define CATEGORIES 4 /* of messages */

typedef struct Host {
    Instance instance;
    const fmi2CallbackFunctions *callbacks;
    char name[256];
} Host;

/* Hand a text to a logger: as its format, with percent signs doubled, as not every host formats. */
static void hand_on(const fmi2CallbackFunctions *to, const char *name, int status, const char *category,
        const char *text) {
    char format[2 * sizeof((Instance *) 0)->reason];
    size_t length = 0;
    if (!to || !to->logger) return;
    for (; *text && length < sizeof format - 2; text++) {
        if (*text == '%') format[length++] = '%';
        format[length++] = *text;
    }
    format[length] = 0;
    to->logger(to->componentEnvironment, name, (fmi2Status) status, category, format);
}

static void tell(Instance *one, int status, const char *category, const char *text) {
    Host *host = one->host;
    hand_on(host->callbacks, host->name, status, category, text);
}

static fmi2Status failed(Host *host, fmi2Status status) {
    hand_on(host->callbacks, host->name, status,
            status == fmi2Discard ? "logStatusDiscard" : "logStatusError", host->instance.reason);
    return status;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count,
        const fmi2String categories[]) {
    Host *host = c;
    const int before = host->instance.logged;
    host->instance.logged = 0; /* here a call says all that is logged; in FMI 3.0 it says what changes */
    if (switch_logging(&host->instance, on, count, categories, CATEGORIES)) {
        host->instance.logged = before;
        return failed(host, fmi2Error);
    }
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
        const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    Host *host;
    (void) resources, (void) visible;
    if (type != fmi2CoSimulation || !guid || strcmp(guid, GUID) != 0) {
        hand_on(functions, name ? name : "", fmi2Error, "logStatusError",
                type != fmi2CoSimulation ? "this FMU is for co-simulation only"
                : "the GUID is not that of the model description");
        return NULL;
    }
    host = malloc(sizeof *host);
    if (!host) return NULL;
    memset(host, 0, sizeof *host);
    host->callbacks = functions;
    switch_logging(&host->instance, logging, 0, NULL, CATEGORIES);
    snprintf(host->name, sizeof host->name, "%s", name ? name : "");
    host->instance.host = host;
    reset_instance(&host->instance);
    return host;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance,
        fmi2Real start, fmi2Boolean has_stop, fmi2Real stop) {
    Host *host = c;
    State *now = &host->instance.now;
    if (misplaced(&host->instance, "fmi2SetupExperiment", INSTANTIATED)) return failed(host, fmi2Error);
    now->start = start;
    now->end = has_stop ? stop : -UNBOUNDED;
    now->tolerance = has_tolerance ? tolerance : 0.0;
    now->ready = 0;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    Host *host = c;
    if (misplaced(&host->instance, "fmi2EnterInitializationMode", INSTANTIATED)) {
        return failed(host, fmi2Error);
    }
    host->instance.now.mode = INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Host *host = c;
    if (misplaced(&host->instance, "fmi2ExitInitializationMode", INITIALIZATION)) {
        return failed(host, fmi2Error);
    }
    return end_initialisation(&host->instance) ? failed(host, fmi2Error) : fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
    Host *host = c;
    if (misplaced(&host->instance, "fmi2Terminate", STEP)) return failed(host, fmi2Error);
    host->instance.now.mode = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    reset_instance(&((Host *) c)->instance);
    return fmi2OK;
}

/* ---- variables ----------------------------------------------------------------------------- */

#define GET(Name, Type, KIND, VALUE)                                                                \
    fmi2Status fmi2Get##Name(fmi2Component c, const fmi2ValueReference vr[], size_t count,          \
            Type value[]) {                                                                         \
        Host *host = c;                                                                             \
        for (size_t k = 0; k < count; k++) {                                                        \
            if (!is_of_kind(&host->instance, vr[k], KIND)) return failed(host, fmi2Error);          \
            value[k] = (Type) (VALUE);                                                              \
        }                                                                                           \
        return fmi2OK;                                                                              \
    }

#define SET(Name, Type, KIND, set)                                                                  \
    fmi2Status fmi2Set##Name(fmi2Component c, const fmi2ValueReference vr[], size_t count,          \
            const Type value[]) {                                                                   \
        Host *host = c;                                                                             \
        if (misplaced(&host->instance, "fmi2Set" #Name, INSTANTIATED | INITIALIZATION | STEP)) {    \
            return failed(host, fmi2Error);                                                         \
        }                                                                                           \
        for (size_t k = 0; k < count; k++) {                                                        \
            if (!is_of_kind(&host->instance, vr[k], KIND) ||                                        \
                set(&host->instance, vr[k], value[k])) {                                            \
                return failed(host, fmi2Error);                                                     \
            }                                                                                       \
        }                                                                                           \
        return fmi2OK;                                                                              \
    }

GET(Real, fmi2Real, REAL, get_value(&host->instance, vr[k]))
GET(Integer, fmi2Integer, INTEGER, get_value(&host->instance, vr[k]))
GET(Boolean, fmi2Boolean, BOOLEAN, get_value(&host->instance, vr[k]) != 0.0)
GET(String, fmi2String, STRING, variables[vr[k]].text)
SET(Real, fmi2Real, REAL, set_value)
SET(Integer, fmi2Integer, INTEGER, set_value)
SET(Boolean, fmi2Boolean, BOOLEAN, set_value)
SET(String, fmi2String, STRING, set_text)

/* ---- steps --------------------------------------------------------------------------------- */

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real size, fmi2Boolean no_return) {
    Host *host = c;
    Instance *one = &host->instance;
    (void) no_return;
    if (misplaced(one, "fmi2DoStep", STEP)) return failed(host, fmi2Error);
    return make_step(one, time, size) ? failed(host, fmi2Discard) : fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    fail(&((Host *) c)->instance, "no step can be cancelled: each has ended when fmi2DoStep returns");
    return failed(c, fmi2Error);
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = ((Host *) c)->instance.now.conduct.run.time;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = !((Host *) c)->instance.now.ok;
    return fmi2OK;
}

#define NO_STATUS(Name, Type)                                                                       \
    fmi2Status fmi2Get##Name(fmi2Component c, const fmi2StatusKind kind, Type *value) {             \
        (void) c, (void) kind, (void) value;                                                        \
        return fmi2Discard;                                                                         \
    }

NO_STATUS(Status, fmi2Status)
NO_STATUS(IntegerStatus, fmi2Integer)
NO_STATUS(StringStatus, fmi2String)

/* ---- whole state --------------------------------------------------------------------------- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    Host *host = c;
    return copy_state(&host->instance, (State **) state) ? failed(host, fmi2Error) : fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    Host *host = c;
    return restore(&host->instance, state) ? failed(host, fmi2Error) : fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void) c;
    free_state(state);
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    (void) c, (void) state;
    *size = SERIALIZED;
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    Host *host = c;
    return write_state(&host->instance, bytes, size, state) ? failed(host, fmi2Error) : fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
        fmi2FMUstate *state) {
    Host *host = c;
    return read_state(&host->instance, bytes, size, (State **) state) ? failed(host, fmi2Error) : fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t count,
        const fmi2Integer order[], fmi2Real value[]) {
    Host *host = c;
    for (size_t k = 0; k < count; k++) {
        if (find_rate(&host->instance, vr[k], order[k], &value[k])) return failed(host, fmi2Error);
    }
    return fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[],
        size_t unknowns, const fmi2ValueReference known[], size_t knowns, const fmi2Real seed[],
        fmi2Real sensitivity[]) {
    Host *host = c;
    if (find_sensitivity(&host->instance, unknown, unknowns, known, knowns, seed, sensitivity)) {
        return failed(host, fmi2Error);
    }
    return fmi2OK;
}

/* ---- what it cannot do --------------------------------------------------------------------- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t count,
        const fmi2Integer order[], const fmi2Real value[]) {
    (void) vr, (void) count, (void) order, (void) value;
    fail(&((Host *) c)->instance, "derivatives of inputs are not taken");
    return failed(c, fmi2Error);
}
