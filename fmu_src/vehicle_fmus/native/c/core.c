/*
 * One instance: parameters and inputs in, communication steps, outputs out.
 *
 * It calls the kernel as `Session` in Python does, in the same order. The whole state is one record: a
 * copy of it is a snapshot.
 */

#define AT_REST 1e-12 /* s by which a communication point may precede the present, from rounding */

typedef struct State {
    Machine machine, behind; /* behind: before the step in which the integrator went ahead */
    Conduct conduct;
    double parameters[VARIABLES], used[VARIABLES]; /* by value reference; as set, and as in use */
    double inputs[VARIABLES];                      /* set before the end of initialisation */
    char is_set[VARIABLES];
    double derived[DERIVED];
    double start, tolerance;
    int initialised; /* whether initialisation has ended */
    int ready;       /* whether machine and conduct belong to the parameters */
    int ok, tuned, warned, passed_over;
} State;

typedef struct Instance {
    State now;
    char reason[1024]; /* why the last call failed */
    char refusal[512]; /* why the next step cannot be made */
    int quiet, forces_known, roads_known;
    double roads[SIGNALS + 1][4];
    void *host;
} Instance;

/* Given by the layer of an FMI version: tell the host something. */
static void tell(Instance *one, int is_error, const char *category, const char *text);

static void say(Instance *one, const char *category, const char *format, ...) {
    char text[1024];
    va_list values;
    if (one->quiet) return;
    va_start(values, format);
    vsnprintf(text, sizeof text, format, values);
    va_end(values);
    tell(one, 0, category, text);
}

/* Note why a call fails; return 1. */
static int fail(Instance *one, const char *format, ...) {
    va_list values;
    va_start(values, format);
    vsnprintf(one->reason, sizeof one->reason, format, values);
    va_end(values);
    return 1;
}

static void wire(Instance *one) {
    State *now = &one->now;
    machine_wire(&now->machine);
    conduct_wire(&now->conduct);
    now->conduct.run.integrator = &now->machine.integrator;
    now->conduct.rest.net = now->machine.integrator.net;
    one->forces_known = one->roads_known = 0;
}

static void reset_instance(Instance *one) {
    State *now = &one->now;
    memset(now, 0, sizeof *now);
    for (int k = 0; k < VARIABLES; k++) now->parameters[k] = variables[k].start;
    now->ok = 1;
    one->reason[0] = one->refusal[0] = 0;
    one->quiet = 0;
    now->conduct = conduct_as_packed;
    now->machine = machine_as_packed;
    wire(one);
}

/* ---- parameters ---------------------------------------------------------------------------- */

static int check_parameters(Instance *one, const double *p) {
    for (int k = 0; k < VARIABLES; k++) {
        const Variable *v = &variables[k];
        if (v->causality != PARAMETER || v->kind == STRING) continue;
        if (v->kind != REAL && p[k] != v->start) {
            return fail(one, "%s = %g: this FMU was packed for %s = %g, on which its structure "
                        "depends; pack another with --set %s=%g",
                        v->name, p[k], v->name, v->start, v->name, p[k]);
        }
        if (!isfinite(p[k]) || (v->positive && p[k] <= 0.0) || p[k] < v->minimum ||
            p[k] > v->maximum) {
            return fail(one, "%s = %g: must be %s", v->name, p[k], v->range);
        }
    }
    return 0;
}

/* Make a machine for the present parameters, at a time; on failure it is as good as none. */
static int make_machine(Instance *one, Machine *machine, double time) {
    State *now = &one->now;
    double p[VARIABLES], row[ROW];
    int guard;
    memcpy(p, now->parameters, sizeof p);
    if (check_parameters(one, p)) return 1;
    if (SOLVER_TOLERANCE >= 0 && now->tolerance > 0.0 && p[SOLVER_TOLERANCE] == DEFAULT_TOLERANCE) {
        p[SOLVER_TOLERANCE] = now->tolerance;
        if (check_parameters(one, p)) return 1;
    }
    *machine = machine_as_packed;
    machine_wire(machine);
    guard = set_up(p, machine, row, now->derived);
    if (guard) return fail(one, "%s", guards[guard - 1]);
    if (Integrator_begin_row(&machine->integrator, row, 0, time) != 0) {
        return fail(one, "the mass matrix must be symmetric and positive definite; check masses and "
                    "inertias");
    }
    memcpy(now->used, now->parameters, sizeof now->used);
    return 0;
}

/* ---- steps --------------------------------------------------------------------------------- */

/* Count the contact switches up to a time, and report them. */
static void count_contacts(Instance *one, double until) {
    Run *run = &one->now.conduct.run;
    int c;
    while ((c = Run_next_contact(run, until)) >= 0) {
        const int airborne = run->airborne[c];
        say(one, "logEvents", "%s%s at %.9g s", wheels[c], airborne ? "lift-off" : "touchdown",
            airborne ? run->last_lift_off[c] : run->last_touchdown[c]);
    }
}

/* Take the switches that the integrator has noted; those of contact wait for their time. */
static void note_switches(Instance *one, double until) {
    Integrator *integrator = &one->now.machine.integrator;
    Run *run = &one->now.conduct.run;
    for (int k = 0; k < integrator->event_count; k++) {
        const double time = integrator->event_time[k];
        const int *what = integrator->event_what + 4 * k;
        const int e = what[0], before = what[2], after = what[3];
        if (what[1] == CONTACT && elements[e].is_tyre) {
            Run_note_contact(run, time, e, after);
            if (time <= until) count_contacts(one, time);
        } else if (elements[e].stop) {
            const int met = (after < before) == (elements[e].stop == 1);
            say(one, "logEvents", "%s %s at %.9g s", elements[e].name, met ? "met" : "left", time);
        }
    }
    integrator->event_count = integrator->event_base = 0;
}

static int step(Instance *one, double until, int stop) {
    State *now = &one->now;
    Integrator *integrator = &now->machine.integrator;
    int status;
    Integrator__look_at_pace(integrator);
    for (;;) {
        status = Integrator__advance(integrator, until, stop);
        note_switches(one, one->quiet ? -INFINITY : until);
        integrator->since_pause = 0;
        if (status != PAUSED) break;
        if (!Integrator_keeps_pace(integrator, until)) {
            status = TOO_MANY;
            break;
        }
    }
    if (integrator->watch->beyond_since != -1e300 && !now->warned) {
        now->warned = 1;
        say(one, "logAll", "solver.step = %g s is not stable from %.6g s on: it is divided into parts "
            "of at most %.3g s", integrator->fixed_step, integrator->watch->beyond_since,
            integrator->watch->beyond_step);
    }
    if (integrator->overruns && !now->passed_over) {
        now->passed_over = 1;
        say(one, "logAll", "switches follow one another without time between them, the first by "
            "%.6g s: passed over, results may be less exact there", integrator->time);
    }
    if (status == 0) return 0;
    now->ok = 0;
    now->conduct.run.time = integrator->time;
    return fail(one, "%s at %.6g s, in step %lld; %s", failures[status].cause, integrator->time,
                (long long) integrator->step_count, failures[status].remedy);
}

/* Return to the present: repeat the steps up to now if the integrator has gone ahead. */
static int stop_here(Instance *one) {
    State *now = &one->now;
    int status;
    if (now->machine.integrator.time <= now->conduct.run.time) return 0;
    now->machine = now->behind;
    machine_wire(&now->machine);
    one->quiet = 1; /* what happened up to now was reported when it was first passed */
    status = step(one, now->conduct.run.time, 1);
    one->quiet = 0;
    Run_forget_waiting(&now->conduct.run);
    return status;
}

/* Rebuild the system with the parameters set, and continue from the present state. */
static int take_parameters(Instance *one) {
    State *now = &one->now;
    Run *run = &now->conduct.run;
    int counterpart[ELEMENTS];
    now->tuned = 0;
    if (memcmp(now->parameters, now->used, sizeof now->used) == 0) return 0;
    if (stop_here(one) || make_machine(one, &now->behind, run->time)) return 1;
    for (int e = 0; e < ELEMENTS; e++) counterpart[e] = e;
    Run_hand_on(run, &now->behind.integrator, counterpart);
    now->machine = now->behind;
    machine_wire(&now->machine);
    Run_compare_contacts(run);
    return 0;
}

/* Start from equilibrium on the present road, plus the initial values. */
static int start_moving(Instance *one) {
    State *now = &one->now;
    Integrator *integrator = &now->machine.integrator;
    double state[2 * COORDINATES];
    int same = 1;
    if (Run_find_rest(&now->conduct.run)) {
        return fail(one, "no static equilibrium was found: every coordinate must be held by springs that "
                    "can carry its load");
    }
    for (int i = 0; i < COORDINATES; i++) {
        state[i] = now->conduct.rest.q[i] + now->derived[i];
        state[COORDINATES + i] = now->derived[COORDINATES + i];
    }
    Integrator_sample(integrator, now->conduct.run.time);
    for (int i = 0; i < COORDINATES; i++) {
        same = same && state[i] == integrator->sample_q[i] &&
            state[COORDINATES + i] == integrator->sample_v[i];
    }
    if (!same) {
        Integrator__enter_state(integrator, state, 0);
        now->behind = now->machine;
    }
    Run_begin_contacts(&now->conduct.run);
    return 0;
}

static void sample(Instance *one) {
    Run *run = &one->now.conduct.run;
    count_contacts(one, run->time);
    Integrator_sample(run->integrator, run->time);
    one->forces_known = one->roads_known = 0;
}

static int advance(Instance *one, double until) {
    State *now = &one->now;
    Run *run = &now->conduct.run;
    if (!now->ok) return fail(one, "the run has already failed, at %.9g s", run->time);
    if (!isfinite(until) || until < run->time - AT_REST) {
        return fail(one, "cannot step from %.9g s to %.9g s: the end of a step must be finite and not "
                    "before its start", run->time, until);
    }
    if (now->tuned && take_parameters(one)) return 1;
    if (Run_sets_in(run)) {
        if (stop_here(one)) return 1;
        run->sampled = 1;
    }
    if (Run_hand_over(run, until) && run->time == run->start) {
        if (start_moving(one)) return 1;
        now->machine.integrator.event_count = now->machine.integrator.event_base = 0;
    }
    if (run->time > run->start) note_switches(one, -INFINITY);
    if (run->time == run->start && run->start < until) {
        for (int c = 0; c < run->tyres; c++) {
            if (run->airborne[c]) say(one, "logEvents", "%swheel in the air at the start", wheels[c]);
        }
    }
    if (now->machine.integrator.time < until) {
        if (!run->sampled) now->behind = now->machine;
        if (step(one, until, run->sampled)) return 1;
    }
    run->time = until;
    sample(one);
    return 0;
}

/* Make the machine from parameters and inputs, at the start. */
static int begin(Instance *one) {
    State *now = &one->now;
    Run *run = &now->conduct.run;
    now->ready = 0;
    now->ok = 1;
    now->tuned = now->warned = now->passed_over = 0;
    if (make_machine(one, &now->machine, now->start)) return 1;
    now->behind = now->machine;
    now->conduct = conduct_as_packed;
    wire(one);
    Run_begin(run, now->start);
    if (start_moving(one)) return 1;
    now->machine.integrator.event_count = now->machine.integrator.event_base = 0;
    sample(one);
    for (int k = 0; k < VARIABLES; k++) {
        if (now->is_set[k]) Run_set_input(run, variables[k].index, now->inputs[k]);
    }
    if (advance(one, now->start)) return 1;
    now->ready = 1;
    return 0;
}

/* ---- variables ----------------------------------------------------------------------------- */

static void refuse(Instance *one, const char *format, ...) {
    va_list values;
    if (one->refusal[0]) return;
    va_start(values, format);
    vsnprintf(one->refusal, sizeof one->refusal, format, values);
    va_end(values);
    tell(one, 1, "logStatusError", one->refusal);
}

static void set_value(Instance *one, unsigned k, double value) {
    State *now = &one->now;
    const Variable *v = &variables[k];
    if (v->causality == OUTPUT) {
        refuse(one, "%s = %g: an output cannot be set", v->name, value);
    } else if (v->causality == INPUT) {
        if (now->initialised && !isfinite(value)) {
            refuse(one, "input %s = %g: must be finite", v->name, value);
            return;
        }
        now->inputs[k] = value;
        now->is_set[k] = 1;
        if (now->initialised) {
            Run_set_input(&now->conduct.run, v->index, value);
        } else {
            now->ready = 0;
        }
    } else if (!now->initialised) {
        now->parameters[k] = value + 0.0; /* never -0 */
        now->ready = 0;
    } else if (!v->tunable || v->kind != REAL) {
        refuse(one, "%s = %g: this parameter cannot change during a run", v->name, value);
    } else if (!isfinite(value) || (v->positive && value <= 0.0) || value < v->minimum ||
               value > v->maximum) {
        refuse(one, "%s = %g: must be %s", v->name, value, v->range);
    } else {
        now->parameters[k] = value + 0.0;
        now->tuned = 1;
    }
}

static void set_text(Instance *one, unsigned k, const char *text) {
    const Variable *v = &variables[k];
    if (strcmp(text, v->text) != 0) {
        refuse(one, "%s = '%s': this FMU was packed for '%s', on which its structure depends; pack "
               "another with --set %s=...", v->name, text, v->text, v->name);
    }
}

static void find_forces(Instance *one) {
    if (!one->forces_known) {
        Integrator_sample_forces(one->now.conduct.run.integrator, one->now.conduct.run.time);
        one->forces_known = 1;
    }
}

static void find_roads(Instance *one) {
    if (!one->roads_known) {
        Run *run = &one->now.conduct.run;
        for (int s = 0; s < SIGNALS; s++) {
            Network_signal_at(run->integrator->net, s, run->time, 1);
            for (int k = 0; k < 4; k++) one->roads[s][k] = run->integrator->net->road[4 * s + k];
        }
        one->roads_known = 1;
    }
}

static double get_value(Instance *one, unsigned k) {
    State *now = &one->now;
    const Variable *v = &variables[k];
    if (v->causality == PARAMETER) return now->parameters[k];
    if (v->causality == INPUT) {
        return now->initialised ? now->conduct.run.value[v->index]
                                : now->is_set[k] ? now->inputs[k] : v->start;
    }
    if (!now->ready && !now->initialised) begin(one); /* reported at the end of initialisation */
    if ((int) k == OK) return now->ready && now->ok;
    if (!now->ready || !now->ok) return v->kind == REAL ? NAN : 0.0;
    if (needs_forces(k)) find_forces(one);
    if (needs_roads(k)) find_roads(one);
    return find_output(&now->machine.integrator, &now->conduct.run, now->derived, one->roads, k);
}

/* ---- whole state --------------------------------------------------------------------------- */

static void restore(Instance *one, const State *state) {
    one->now = *state;
    one->refusal[0] = 0;
    wire(one);
}
