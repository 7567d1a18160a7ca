/* A host of one native FMU of FMI 2.0, for any platform: loads the library and does one of these.
 *
 *     loading LIBRARY GUID run STEPS SIZE NAMES...   print outputs, by value reference, after every step
 *     loading LIBRARY GUID refuse REFERENCE VALUE    set a parameter, print how initialisation ends
 *     loading LIBRARY GUID cycles COUNT              make and end instances; print bytes of the heap before, after
 *     loading LIBRARY GUID time STEPS SIZE NAMES...  print ns of processor time: of a step with its
 *                                                    outputs read, of making an instance, least of several
 *     loading LIBRARY GUID tune STEPS SIZE REFERENCE VALUE
 *                                                    print ns of processor time of a step, and of one
 *                                                    before which the parameter is set to another value
 */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fmi2FunctionTypes.h"

#ifdef _WIN32
#include <windows.h>
#define OPEN(path) ((void *) LoadLibraryA(path))
#define FIND(library, name) ((void *) GetProcAddress((HMODULE) library, name))
#define CLOSE(library) FreeLibrary((HMODULE) library)
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW | RTLD_LOCAL)
#define FIND(library, name) dlsym(library, name)
#define CLOSE(library) dlclose(library)
#endif

#define IN_USE 0L /* bytes of the heap, where the C library tells */
#ifdef __GLIBC__
#if __GLIBC_PREREQ(2, 33)
#include <malloc.h>
#undef IN_USE
#define IN_USE ((long) mallinfo2().uordblks)
#endif
#endif

#define MOST 64

static fmi2InstantiateTYPE *instantiate;
static fmi2FreeInstanceTYPE *free_instance;
static fmi2SetupExperimentTYPE *setup;
static fmi2EnterInitializationModeTYPE *enter;
static fmi2ExitInitializationModeTYPE *leave;
static fmi2DoStepTYPE *do_step;
static fmi2GetRealTYPE *get_real;
static fmi2SetRealTYPE *set_real;

static const char *guid;
static fmi2ValueReference names[MOST];
static fmi2Real values[MOST];

static void logger(fmi2ComponentEnvironment host, fmi2String name, fmi2Status status,
        fmi2String category, fmi2String message, ...) {
    (void) host, (void) name, (void) status, (void) category, (void) message;
}

static const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};

static fmi2Component made(void) {
    fmi2Component one = instantiate("one", fmi2CoSimulation, guid, "", &callbacks, 0, 0);
    if (!one) exit(3);
    setup(one, 0, 0.0, 0.0, 0, 0.0);
    enter(one);
    return one;
}

static fmi2Component begun(void) {
    fmi2Component one = made();
    if (leave(one) != fmi2OK) exit(4);
    return one;
}

static double seconds(void) {
    return (double) clock() / CLOCKS_PER_SEC;
}

static void run(int steps, double size, int count) {
    fmi2Component one = begun();
    for (int k = 0; k < steps; k++) {
        if (do_step(one, k * size, size, 1) != fmi2OK) exit(5);
        get_real(one, names, count, values);
        for (int i = 0; i < count; i++) printf("%a ", values[i]);
        printf("\n");
    }
    free_instance(one);
}

static void measure(int steps, double size, int count) {
    double step = 1e9, making = 1e9;
    for (int round = 0; round < 20; round++) {
        double start = seconds();
        fmi2Component one;
        for (int k = 0; k < 50; k++) free_instance(begun());
        making = (seconds() - start) / 50 < making ? (seconds() - start) / 50 : making;
        one = begun();
        start = seconds();
        for (int k = 0; k < steps; k++) {
            do_step(one, k * size, size, 1);
            get_real(one, names, count, values);
        }
        step = (seconds() - start) / steps < step ? (seconds() - start) / steps : step;
        free_instance(one);
    }
    printf("%.1f %.1f\n", 1e9 * step, 1e9 * making);
}

static double time_of_step(int steps, double size, double value) {
    double least = 1e9;
    for (int round = 0; round < 20; round++) {
        fmi2Component one = begun();
        const double start = seconds();
        for (int k = 0; k < steps; k++) {
            values[0] = k % 2 ? value : 1.01 * value;
            if (value != 0.0) set_real(one, names, 1, values);
            if (do_step(one, k * size, size, 1) != fmi2OK) exit(5);
        }
        least = (seconds() - start) / steps < least ? (seconds() - start) / steps : least;
        free_instance(one);
    }
    return least;
}

static void cycle(int count) {
    for (int k = 0; k < 100; k++) free_instance(begun());
    const long before = IN_USE;
    for (int k = 0; k < count; k++) {
        fmi2Component one = begun();
        do_step(one, 0.0, 1e-3, 1);
        free_instance(one);
    }
    const long after = IN_USE;
    printf("%ld %ld\n", before, after);
}

int main(int count, char **arguments) {
    void *library = count > 3 ? OPEN(arguments[1]) : NULL;
    const char *what = count > 3 ? arguments[3] : "";
    if (!library) return 2;
    guid = arguments[2];
    instantiate = (fmi2InstantiateTYPE *) FIND(library, "fmi2Instantiate");
    free_instance = (fmi2FreeInstanceTYPE *) FIND(library, "fmi2FreeInstance");
    setup = (fmi2SetupExperimentTYPE *) FIND(library, "fmi2SetupExperiment");
    enter = (fmi2EnterInitializationModeTYPE *) FIND(library, "fmi2EnterInitializationMode");
    leave = (fmi2ExitInitializationModeTYPE *) FIND(library, "fmi2ExitInitializationMode");
    do_step = (fmi2DoStepTYPE *) FIND(library, "fmi2DoStep");
    get_real = (fmi2GetRealTYPE *) FIND(library, "fmi2GetReal");
    set_real = (fmi2SetRealTYPE *) FIND(library, "fmi2SetReal");
    if (strcmp(what, "cycles") == 0) cycle(atoi(arguments[4]));
    if (strcmp(what, "tune") == 0) {
        const int steps = atoi(arguments[4]);
        const double size = atof(arguments[5]), plain = time_of_step(steps, size, 0.0);
        names[0] = (fmi2ValueReference) atoi(arguments[6]);
        printf("%.1f %.1f\n", 1e9 * plain, 1e9 * time_of_step(steps, size, atof(arguments[7])));
    }
    if (strcmp(what, "refuse") == 0) {
        fmi2Component one = made();
        names[0] = (fmi2ValueReference) atoi(arguments[4]);
        values[0] = atof(arguments[5]);
        set_real(one, names, 1, values);
        printf("%d\n", leave(one));
        free_instance(one);
    }
    if (strcmp(what, "run") == 0 || strcmp(what, "time") == 0) {
        for (int i = 6; i < count && i < 6 + MOST; i++) names[i - 6] = (unsigned) atoi(arguments[i]);
        (strcmp(what, "run") == 0 ? run : measure)(atoi(arguments[4]), atof(arguments[5]), count - 6);
    }
    CLOSE(library);
    return 0;
}
