/* A plain C host: ENDING FREED STATUS, then for each FMU its library, GUID and resources.
 *
 * It instantiates every FMU and steps it. ENDING says how it ends: `done`; `refused`, after the last FMU
 * has refused a parameter; `interrupted`, by SIGINT, which it handles; or `killed`, by SIGINT, which it does
 * not handle: once it has written `waiting` it steps until then. The first FREED instances are freed and
 * their libraries closed, the others stay as they are. It exits with STATUS, or at once with 99 where an
 * FMU does otherwise than it should. */
#include <dlfcn.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OK = 0, CO_SIMULATION = 1, MOST = 8 };

typedef struct {
    void (*log)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

typedef struct {
    void *handle, *instance;
} Fmu;

static volatile sig_atomic_t interrupted;

static void interrupt(int number) {
    interrupted = number;
}

static void ignore(void *environment, const char *name, int status, const char *category,
                   const char *message, ...) {
    (void)environment, (void)name, (void)status, (void)category, (void)message;
}

static void expect(int holds, const char *what) {
    if (!holds) {
        fprintf(stderr, "not as it should: %s\n", what);
        _Exit(99);
    }
}

static void *function(const Fmu *fmu, const char *name) {
    void *found = dlsym(fmu->handle, name);
    expect(found != NULL, name);
    return found;
}

static int call(const Fmu *fmu, const char *name) {
    return ((int (*)(void *))function(fmu, name))(fmu->instance);
}

static int step(const Fmu *fmu, double time, double size) {
    return ((int (*)(void *, double, double, int))function(fmu, "fmi2DoStep"))(fmu->instance, time, size, 1);
}

static Fmu opened(const char *library, const char *guid, const char *resources, const Callbacks *callbacks) {
    Fmu fmu = {dlopen(library, RTLD_NOW | RTLD_LOCAL), NULL};
    expect(fmu.handle != NULL, "load");
    fmu.instance = ((void *(*)(const char *, int, const char *, const char *, const Callbacks *, int, int))
                        function(&fmu, "fmi2Instantiate"))("vehicle", CO_SIMULATION, guid, resources, callbacks, 0, 0);
    expect(fmu.instance != NULL, "fmi2Instantiate");
    int status = ((int (*)(void *, int, double, double, int, double))function(&fmu, "fmi2SetupExperiment"))(
        fmu.instance, 0, 0.0, 0.0, 0, 0.0);
    expect(status == OK, "fmi2SetupExperiment");
    expect(call(&fmu, "fmi2EnterInitializationMode") == OK, "fmi2EnterInitializationMode");
    return fmu;
}

int main(int count, char **given) {
    const char *ending = given[1];
    int freed = atoi(given[2]), status = atoi(given[3]), fmus = (count - 4) / 3;
    const Callbacks callbacks = {ignore, calloc, free, NULL, NULL};
    Fmu all[MOST];
    int handled = strcmp(ending, "interrupted") == 0;
    expect(fmus <= MOST, "number of FMUs");
    if (handled) signal(SIGINT, interrupt);
    for (int k = 0; k < fmus; k++) {
        char **of = given + 4 + 3 * k;
        all[k] = opened(of[0], of[1], of[2], &callbacks);
        int refused = k == fmus - 1 && strcmp(ending, "refused") == 0;
        if (refused) {
            const unsigned first = 0;
            const double negative = -1.0;
            ((int (*)(void *, const unsigned *, size_t, const double *))function(&all[k], "fmi2SetReal"))(
                all[k].instance, &first, 1, &negative);
        }
        /* from Python 3.12 on the FMU refuses only the first step */
        int good = call(&all[k], "fmi2ExitInitializationMode") == OK && step(&all[k], 0.0, 0.01) == OK;
        expect(good != refused, "initialisation and first step");
    }
    if (handled || strcmp(ending, "killed") == 0) {
        puts("waiting");
        fflush(stdout);
        for (int k = 1; !interrupted; k++) expect(step(&all[0], 0.01 * k, 0.01) == OK, "fmi2DoStep");
    }
    for (int k = 0; k < freed; k++) {
        ((void (*)(void *))function(&all[k], "fmi2FreeInstance"))(all[k].instance);
        dlclose(all[k].handle);
    }
    return status;
}
