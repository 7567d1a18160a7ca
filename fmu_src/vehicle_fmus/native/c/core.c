/*
 * One instance: parameters and inputs in, communication steps, outputs out.
 *
 * It calls the kernel as `Session` in Python does, in the same order. The whole state is one record: a
 * copy of it is the state of the FMU.
 */

#define OFF_BY 1e-6 /* of its time, at least 1 s, by which a host may be off: it may count in single precision */
#define PLACES 5 /* of a function whose derivative is that of the polynomial through them */
#define APART 1e-3 /* distance of these places, of the size of what is varied */
enum { FINE, WARNING }; /* what a message is, as in both versions of FMI */
enum { INSTANTIATED = 1, INITIALIZATION = 2, EVENT = 4, STEP = 8, TERMINATED = 16, LOOKING = 32 };
#define DUE 4 /* instants that can wait: at most two of one step, and one of the inputs */

typedef struct Stop {
    double time;
    int element, met; /* whether the end stop was met, or left */
} Stop;

typedef struct State {
    Machine machine;
    Snapshot behind; /* before the step in which the integrator went ahead */
    Conduct conduct;
    double parameters[VARIABLES], used[VARIABLES]; /* by value reference; as set, and as in use */
    double inputs[VARIABLES];                      /* set before the end of initialisation */
    char is_set[VARIABLES];
    double row[ROW], fields[FIELDS], derived[DERIVED]; /* found from the parameters in use */
    double start, end, tolerance; /* the end is -UNBOUNDED if the host does not know it */
    double handed; /* end of the step for which the courses of the inputs were found, until one is set */
    int kept;      /* whether `behind` is of that step */
    int ready;       /* whether machine and conduct belong to the parameters */
    int ok, tuned, warned, passed_over;
    double due[DUE]; /* instants of switches that the host has not been told of */
    int dues, switched; /* switched: whether the last step of the host had one */
    Stop stop[DUE];     /* end stops met or left that are yet to be reported */
    int stops;
    char met[ELEMENTS]; /* whether the last report of an end stop says that it was met */
    int mode; /* INSTANTIATED or another of these; EVENT and LOOKING are of FMI 3.0 alone */
    char ticks[2 * TYRES + 1]; /* lift-off and touchdown of each tyre since the last look */
    char refusal[1024]; /* why the next step cannot be made */
} State;

typedef struct Instance {
    State now;
    int event_mode;   /* whether contacts are counted by the host's event mode, not by its steps */
    int early_return; /* whether steps end on switches */
    int idle;         /* whether the host has been told that an input has no effect */
    int logged;       /* categories of messages that the host wants; failures are always told */
    double (*update)(struct Instance *, double); /* called within steps; see `go_on` */
    char reason[1024]; /* why the last call failed */
    int quiet, forces_known, roads_known, energies_known;
    double roads[SIGNALS + 1][4];
    double row[ROW], fields[FIELDS]; /* as found last; those in use are in the state */
    Work work;
    Machine other; /* that takes the place of the present one */
    void *host;
} Instance;

/* Given by the layer of an FMI version: tell the host something. */
static void tell(Instance *one, int status, const char *category, const char *text);

/* The categories of messages; the model description of an FMI version has so many of them. */
static const char *const categories_known[] = {
    "logEvents", "logStatusWarning", "logStatusError", "logStatusDiscard"};
enum { EVENTS, WARNINGS };

static void say(Instance *one, int status, const char *format, ...) {
    const int category = status == FINE ? EVENTS : WARNINGS;
    char text[1024];
    va_list values;
    if (one->quiet || !(one->logged & 1 << category)) return;
    va_start(values, format);
    vsnprintf(text, sizeof text, format, values);
    va_end(values);
    tell(one, status, categories_known[category], text);
}

/* Note why a call fails; return 1. */
static int fail(Instance *one, const char *format, ...) {
    va_list values;
    va_start(values, format);
    vsnprintf(one->reason, sizeof one->reason, format, values);
    va_end(values);
    return 1;
}

/* Switch categories of messages on or off, all if none is named; return whether a name is unknown. */
static int switch_logging(Instance *one, int on, size_t count, const char *const names[], int known) {
    int chosen = count ? 0 : (1 << known) - 1;
    for (size_t i = 0; i < count; i++) {
        const char *name = names && names[i] ? names[i] : "";
        int k = 0;
        while (k < known && strcmp(name, categories_known[k]) != 0) k++;
        if (k == known) {
            char all[128] = "";
            for (k = 0; k < known; k++) {
                strcat(strcat(all, k ? ", " : ""), categories_known[k]);
            }
            return fail(one, "there is no category '%s' of messages, but only %s", name, all);
        }
        chosen |= 1 << k;
    }
    one->logged = on ? one->logged | chosen : one->logged & ~chosen;
    return 0;
}

/* Return whether a call is out of place in the present mode, and note that. */
static int misplaced(Instance *one, const char *call, int allowed) {
    static const char *const modes[] = {"after instantiation", "in initialization mode", "in event mode",
        "in step mode", "after the end", "in intermediate update mode"};
    char places[256] = "";
    int k = 0;
    if (one->now.mode & allowed) return 0;
    while (one->now.mode >> (k + 1)) k++;
    for (size_t i = 0; i < sizeof modes / sizeof modes[0]; i++) {
        const size_t used = strlen(places);
        if (!(allowed & 1 << i)) continue;
        snprintf(places + used, sizeof places - used, "%s %s", used ? " or" : "", modes[i]);
    }
    return fail(one, "%s cannot be called %s, but only%s%s", call, modes[k], places,
                one->now.mode == TERMINATED ? ": first reset the FMU, or restore a state" : "");
}

static int is_initialised(const State *now) { return now->mode > INITIALIZATION; }

/* Note that what outputs are read from is not that of the present time. */
static void forget(Instance *one) {
    one->forces_known = one->roads_known = one->energies_known = 0;
}

static void wire(Instance *one) {
    State *now = &one->now;
    machine_wire(&now->machine);
    conduct_wire(&now->conduct);
    now->conduct.run.integrator = &now->machine.integrator;
    now->conduct.rest.net = now->machine.integrator.net;
    forget(one);
}

static void reset_instance(Instance *one) {
    State *now = &one->now;
    memset(now, 0, sizeof *now);
    for (int k = 0; k < VARIABLES; k++) now->parameters[k] = variables[k].start;
    now->ok = 1;
    now->end = -UNBOUNDED;
    now->mode = INSTANTIATED;
    one->reason[0] = 0;
    one->quiet = one->idle = 0;
    conduct_make(&now->conduct);
    machine_make(&now->machine);
    wire(one);
}

/* ---- parameters ---------------------------------------------------------------------------- */

/* Return whether a variable cannot have a value, and note that. */
static int is_out_of_range(Instance *one, const Variable *v, double value) {
    const int bounded = v->positive || isfinite(v->minimum) || isfinite(v->maximum);
    if (isfinite(value) && !(v->positive && value <= 0.0) && value >= v->minimum &&
        value <= v->maximum) {
        return 0;
    }
    return fail(one, "%s = %g: must be %s%s", v->name, value,
                bounded && !isfinite(value) ? "finite and " : "", v->range);
}

/* Write a whole number or a switch as `--set` takes it. */
static void write_whole(const Variable *v, double value, char *to, size_t size) {
    if (v->kind == BOOLEAN) snprintf(to, size, "%s", value != 0.0 ? "true" : "false");
    else snprintf(to, size, "%.0f", value);
}

static int check_parameters(Instance *one, const double *p) {
    for (int k = 0; k < VARIABLES; k++) {
        const Variable *v = &variables[k];
        if (v->causality != PARAMETER || v->kind == STRING) continue;
        if (v->kind != REAL && p[k] != v->start) {
            char given[32], packed[32];
            write_whole(v, p[k], given, sizeof given);
            write_whole(v, v->start, packed, sizeof packed);
            return fail(one, "%s = %s: this FMU was packed for %s, on which its structure depends; pack "
                        "another with --set %s=%s", v->name, given, packed, v->name, given);
        }
        if (is_out_of_range(one, v, p[k])) return 1;
    }
    return 0;
}

/* Find the numbers of the system with the present parameters; the host's tolerance replaces the default.
 *
 * During a run only those that depend on parameters that may change are found; see `tuned`.
 */
static int find_numbers(Instance *one, int in_run) {
    State *now = &one->now;
    double p[VARIABLES];
    int guard = 0;
    memcpy(p, now->parameters, sizeof p);
#ifdef DEFAULT_TOLERANCE
    if (now->tolerance != 0.0 && p[V_SOLVER_TOLERANCE] == DEFAULT_TOLERANCE) {
        p[V_SOLVER_TOLERANCE] = now->tolerance;
    }
#endif
    if (check_parameters(one, p)) return 1;
    if (in_run) {
        memcpy(one->fields, now->fields, sizeof one->fields);
    } else {
        memcpy(one->row, row_as_packed, sizeof one->row);
        guard = set_up_what_stays(p, one->row, one->fields, now->derived, &one->work);
    }
    if (!guard) guard = set_up_what_changes(p, one->row, one->fields, now->derived, &one->work);
    if (guard) return fail(one, "%s", guards[guard - 1]);
    memcpy(now->used, now->parameters, sizeof now->used);
    return 0;
}

/* Find the numbers at the start.
 *
 * A host may give any tolerance: one that this FMU cannot use is ignored, with a warning.
 */
static int find_first_numbers(Instance *one) {
    State *now = &one->now;
    const double given = now->tolerance;
    char why[sizeof one->reason];
    if (find_numbers(one, 0) == 0) return 0;
    if (given == 0.0) return 1;
    memcpy(why, one->reason, sizeof why);
    now->tolerance = 0.0;
    if (find_numbers(one, 0)) {
        now->tolerance = given;
        return 1;
    }
    say(one, WARNING, "the host's tolerance of %g is not used: %s", given, why);
    return 0;
}

/* Use the numbers found during a run; return whether they differ in the laws of elements alone. */
static int use_changes(Instance *one) {
    State *now = &one->now;
    int laws = memcmp(one->fields, now->fields, sizeof one->fields) == 0;
    memcpy(now->fields, one->fields, sizeof one->fields);
    for (int k = 0; k < TUNED; k++) {
        const int at = tuned[k];
        if (at < LAWS && memcmp(&one->row[at], &now->row[at], sizeof one->row[at]) != 0) laws = 0;
        now->row[at] = one->row[at];
    }
    return laws;
}

/* Make a machine of the numbers found, at a time; on failure it must not be used. */
static int make_machine(Instance *one, Machine *machine, double time) {
    State *now = &one->now;
    machine_make(machine);
    enter_fields(now->fields, machine);
    machine->integrator.pace->stop_time = now->end;
    if (Integrator_begin_row(&machine->integrator, now->row, 0, time) != 0) {
        return fail(one, "the mass matrix must be symmetric and positive definite; check masses and "
                    "inertias");
    }
    return 0;
}

/* ---- steps --------------------------------------------------------------------------------- */

/* Count the contact switches up to a time, and report them. */
static void count_contacts(Instance *one, double until) {
    Run *run = &one->now.conduct.run;
    int c;
    while ((c = Contacts_next(run->contacts, until)) >= 0) {
        const int airborne = run->contacts->airborne[c];
        one->now.ticks[2 * c + !airborne] = 1;
        say(one, FINE, "%s%s at %.9g s", wheels[c], airborne ? "lift-off" : "touchdown",
            airborne ? run->contacts->last_lift_off[c] : run->contacts->last_touchdown[c]);
    }
}

/* Report the first end stop that waits for its time; one compressed from the start must be met before. */
static void report_stop(Instance *one) {
    State *now = &one->now;
    const Stop first = now->stop[0];
    now->stops--;
    memmove(now->stop, now->stop + 1, (size_t) now->stops * sizeof first);
    if (first.met || now->met[first.element]) {
        say(one, FINE, "%s %s at %.9g s", elements[first.element].name, first.met ? "met" : "left",
            first.time);
    }
    now->met[first.element] = (char) first.met;
}

/* Report what happened up to a time, and count the contacts. */
static void come_to(Instance *one, double until) {
    while (one->now.stops > 0 && one->now.stop[0].time <= until) {
        count_contacts(one, one->now.stop[0].time);
        report_stop(one);
    }
    count_contacts(one, until);
}

/* Take the first instant off the list if it is not after a time; return whether there was one. */
static int take_due(Instance *one, double until, double *time) {
    State *now = &one->now;
    if (now->dues == 0 || now->due[0] > until) return 0;
    *time = now->due[0];
    now->dues--;
    memmove(now->due, now->due + 1, (size_t) now->dues * sizeof now->due[0]);
    now->switched = 1;
    return 1;
}

/* Let the instant of a switch wait until the host reaches it. */
static void enter_due(Instance *one, double time) {
    State *now = &one->now;
    if (one->quiet || (now->dues > 0 && now->due[now->dues - 1] >= time)) return;
    if (now->dues == DUE) {
        double first;
        take_due(one, INFINITY, &first);
    }
    now->due[now->dues++] = time;
}

/* Take the switches that the integrator has noted; those of contact and end stops wait for their time. */
static void note_switches(Instance *one, double until) {
    State *now = &one->now;
    Integrator *integrator = &now->machine.integrator;
    for (int k = 0; k < integrator->noted->logged; k++) {
        const double time = integrator->noted->time[k];
        const int *what = integrator->noted->what + 4 * k;
        const int e = what[0], before = what[2], after = what[3];
        if (what[1] == CONTACT && elements[e].is_tyre) {
            Contacts_note(now->conduct.run.contacts, time, e, after);
        } else if (elements[e].free >= 0) {
            const int met = before == elements[e].free;
            if (one->quiet || (!met && after != elements[e].free)) continue;
            if (now->stops == DUE) report_stop(one);
            now->stop[now->stops++] = (Stop){time, e, met};
        } else if (!elements[e].yields || what[1] != SPRING) {
            continue;
        }
        enter_due(one, time);
        if (time <= until && !one->event_mode) come_to(one, time);
    }
    integrator->noted->logged = integrator->noted->base = 0;
}

/* Step up to a time or beyond it, or to where the integrator halts for the host. */
static int step(Instance *one, double until, int stop) {
    State *now = &one->now;
    Integrator *integrator = &now->machine.integrator;
    double drift;
    int status;
    integrator->halts = one->quiet ? 0 : one->update ? AT_STEPS : one->early_return ? AT_SWITCHES : 0;
    for (;;) {
        status = Integrator_step_until(integrator, until, stop);
        note_switches(one, one->quiet ? -INFINITY : until);
        if (status == HALTED) status = 0;
        if (status != PAUSED) break;
        integrator->pace->since_pause = 0;
        if (!Pace_keeps_pace(integrator->pace, until)) {
            status = TOO_MANY;
            break;
        }
    }
    if (integrator->state->beyond_since != -UNBOUNDED && !now->warned) {
        now->warned = 1;
        say(one, WARNING, "solver.step = %g s is not stable from %.6g s on: it is divided into parts "
            "of at most %.3g s", integrator->fixed_step, integrator->state->beyond_since,
            integrator->state->beyond_step);
    }
    if (integrator->state->overruns && !now->passed_over) {
        now->passed_over = 1;
        say(one, WARNING, "switches follow one another without time between them, first before "
            "%.6g s: they are passed over; results may be less accurate there", integrator->state->time);
    }
    drift = Account_find_drift(now->conduct.run.account, now->conduct.run.integrator);
    if (drift > 0.0) {
        say(one, WARNING, "errors accumulate: at %.6g s the energy balance is off by %.2g of the total energy; "
            "reduce %s for a long run", integrator->state->time, drift,
            integrator->fixed_step > 0.0 ? "solver.step" : "solver.tolerance");
    }
    if (status == 0) return 0;
    now->ok = 0;
    now->conduct.run.time = integrator->state->time;
    return fail(one, "%s at %.6g s, in step %lld; %s", failures[status].cause, integrator->state->time,
                (long long) integrator->state->step_count,
                integrator->fixed_step > 0.0 ? failures[status].of_fixed_steps : failures[status].remedy);
}

/* Start measuring the pace, unless it is measured across calls up to the end of the run. */
static void look_at_pace(Instance *one, double until) {
    Pace *pace = one->now.machine.integrator.pace;
    pace->since_pause = 0;
    if (pace->stop_time < until) Pace_look_at_pace(pace);
}

/* Note the state of a machine. */
static void take_snapshot(Machine *of, Snapshot *to) {
    Network_take_moving(&of->net);
    *to = of->snapshot;
}

/* Return to a state noted before, as `TimeLoop._resume` does. */
static void go_back(Machine *of, const Snapshot *to) {
    const double datum = of->snapshot.state.datum;
    of->snapshot = *to;
    Integrator__follow_state(&of->integrator, datum);
    of->snapshot = *to;
}

/* Return to the present: repeat the steps up to now if the integrator has gone ahead. */
static int stop_here(Instance *one) {
    State *now = &one->now;
    int status;
    if (now->machine.integrator.state->time <= now->conduct.run.time) return 0;
    go_back(&now->machine, &now->behind);
    one->quiet = 1; /* what happened up to now was reported when it was first passed */
    look_at_pace(one, now->conduct.run.time);
    status = step(one, now->conduct.run.time, 1);
    one->quiet = 0;
    Contacts_forget_waiting(now->conduct.run.contacts);
    now->dues = now->stops = 0;
    return status;
}

/* Let another machine, made of the numbers found, go on from the present state. */
static int replace_machine(Instance *one) {
    State *now = &one->now;
    int counterpart[ELEMENTS];
    if (make_machine(one, &one->other, now->conduct.run.time)) return 1;
    for (int e = 0; e < ELEMENTS; e++) counterpart[e] = e;
    Run_hand_on(&now->conduct.run, &one->other.integrator, counterpart);
    now->machine = one->other;
    machine_wire(&now->machine);
    return 0;
}

/* Continue from the present state with the parameters set.
 *
 * Laws of elements are replaced where they are. Changes of anything else need another machine.
 */
static int take_parameters(Instance *one) {
    State *now = &one->now;
    Run *run = &now->conduct.run;
    now->tuned = 0;
    if (memcmp(now->parameters, now->used, sizeof now->used) == 0) return 0;
    if (stop_here(one)) return 1;
    if (find_numbers(one, 1)) return 1;
    if (use_changes(one)) {
        Run_take_laws(run, now->row, LAWS);
    } else if (replace_machine(one)) {
        return 1;
    }
    now->kept = 0;
    if (run->contacts->waiting > 0) enter_due(one, run->time);
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
        same = same && state[i] == integrator->reading->q[i] &&
            state[COORDINATES + i] == integrator->reading->v[i];
    }
    if (!same) {
        Integrator__enter_state(integrator, state, 0);
        take_snapshot(&now->machine, &now->behind);
    }
    Contacts_begin(now->conduct.run.contacts, now->conduct.run.integrator);
    Account_begin(now->conduct.run.account, now->conduct.run.integrator);
    integrator->noted->logged = integrator->noted->base = 0; /* the start switches nothing */
    return 0;
}

static void sample(Instance *one) {
    Run *run = &one->now.conduct.run;
    if (!one->event_mode) come_to(one, run->time);
    Integrator_sample(run->integrator, run->time);
    forget(one);
}

/* Come to a time within the host's step, and let the host look; return where the step is to end. */
static double update_at(Instance *one, double time, double until) {
    double wanted;
    one->now.conduct.run.time = time;
    sample(one);
    wanted = one->update(one, time);
    return wanted < until ? fmax(wanted, time) : until;
}

/* Step to a time, or with early return to the first switch before it.
 *
 * Where the host looks changes nothing in the motion: the integrator halts at the ends of the steps that
 * it makes anyway.
 */
static int go_on(Instance *one, double until) {
    State *now = &one->now;
    Run *run = &now->conduct.run;
    Integrator *integrator = &now->machine.integrator;
    double time, seen = run->time;
    now->switched = 0;
    look_at_pace(one, until);
    for (;;) {
        if (one->early_return && take_due(one, until, &time)) {
            until = fmax(time, run->time);
            break;
        }
        time = fmin(integrator->state->time, until);
        if (one->update && time > seen) {
            until = update_at(one, time, until);
            seen = time;
        }
        if (integrator->state->time >= until) break;
        if (!run->sampled && !now->kept) take_snapshot(&now->machine, &now->behind);
        now->kept = 1;
        if (step(one, until, run->sampled)) return 1;
    }
    if (one->update && seen < until) update_at(one, until, until);
    while (take_due(one, until, &time)) {}
    run->time = until;
    sample(one);
    return 0;
}

/* Return by how much a point may precede a time, s, from rounding: some units in the last place. */
static double rounding_at(double time) { return fmax(1e-12, 1e-15 * fabs(time)); }

static int advance(Instance *one, double until) {
    State *now = &one->now;
    Run *run = &now->conduct.run;
    if (!now->ok) return fail(one, "the run has already failed, at %.9g s", run->time);
    if (!isfinite(until) || until < run->time - rounding_at(run->time)) {
        return fail(one, "cannot step from %.9g s to %.9g s: the end of a step must be finite and not "
                    "before its start", run->time, until);
    }
    until = fmax(run->time, until);
    const int goes_on = until == now->handed; /* from a switch to the same end, which changes nothing */
    if (now->tuned && take_parameters(one)) return 1;
    if (!goes_on && Run_sets_in(run)) {
        if (stop_here(one)) return 1;
        run->sampled = 1;
    }
    if (!goes_on) now->kept = 0;
    if (!goes_on && Run_hand_over(run, until) && run->time == run->start && start_moving(one)) return 1;
    now->handed = until;
    if (run->time > run->start) note_switches(one, -INFINITY);
    if (run->time == run->start && run->start < until) {
        for (int c = 0; c < TYRES; c++) {
            if (run->contacts->airborne[c]) say(one, FINE, "%swheel in the air at the start", wheels[c]);
        }
    }
    return go_on(one, until);
}

/* Make a communication step of the host; if it fails, outputs are no numbers until a state is restored.
 *
 * It starts at the present, but for rounding: a host that repeats or leaves out steps is refused.
 */
static int make_step(Instance *one, double time, double size) {
    const double present = one->now.conduct.run.time;
    const double off = fmax(fmin(OFF_BY * fmax(1.0, fabs(present)), 0.5 * size), rounding_at(present));
    int status = 1;
    if (one->now.refusal[0]) {
        fail(one, "%s", one->now.refusal);
    } else if (one->now.ok && !(fabs(time - present) <= off)) {
        fail(one, "the host steps from %.12g s, but the FMU is at %.12g s: step from there, or first restore "
             "its state at %.12g s", time, present, time);
    } else {
        status = advance(one, time + size);
    }
    if (status) one->now.ok = 0;
    return status;
}

/* Make the machine from parameters and inputs, at the start. */
static int begin(Instance *one) {
    State *now = &one->now;
    Run *run = &now->conduct.run;
    now->ready = 0;
    now->ok = 1;
    now->handed = -INFINITY;
    now->tuned = now->warned = now->passed_over = now->switched = 0;
    now->dues = now->stops = 0;
    memset(now->ticks, 0, sizeof now->ticks);
    memset(now->met, 0, sizeof now->met);
    if (!isfinite(now->start)) return fail(one, "start time = %g: must be finite", now->start);
    if (find_first_numbers(one)) return 1;
    memcpy(now->row, one->row, sizeof now->row);
    memcpy(now->fields, one->fields, sizeof now->fields);
    if (make_machine(one, &now->machine, now->start)) return 1;
    take_snapshot(&now->machine, &now->behind);
    conduct_make(&now->conduct);
    wire(one);
    Run_begin(run, now->start);
    if (start_moving(one)) return 1;
    sample(one);
    for (int k = 0; k < VARIABLES; k++) {
        if (!now->is_set[k]) continue;
        if (!isfinite(now->inputs[k])) {
            return fail(one, "input %s = %g: must be finite", variables[k].name, now->inputs[k]);
        }
        Run_set_input(run, variables[k].index, now->inputs[k]);
    }
    if (advance(one, now->start)) return 1;
    now->ready = 1;
    return 0;
}

static int end_initialisation(Instance *one) {
    if (one->now.refusal[0]) return fail(one, "%s", one->now.refusal);
    if (begin(one)) return 1;
    one->now.mode = one->event_mode ? EVENT : STEP;
    return 0;
}

/* ---- variables ----------------------------------------------------------------------------- */

/* Return whether there is a variable of this kind, and note if there is none. */
static int is_of_kind(Instance *one, unsigned k, int kind) {
    if (k < VARIABLES && variables[k].kind == kind) return 1;
    fail(one, "value reference %u is not a variable of this type", k);
    return 0;
}

/* Let no step follow what has failed for the reason noted; return 1. */
static int refuse(Instance *one) {
    if (!one->now.refusal[0]) memcpy(one->now.refusal, one->reason, sizeof one->now.refusal);
    return 1;
}

/* Take a value from the host; on failure note why. */
static int take_value(Instance *one, unsigned k, double value) {
    State *now = &one->now;
    const Variable *v = &variables[k];
    if (v->causality == OUTPUT) return fail(one, "%s = %g: an output cannot be set", v->name, value);
    if (v->causality == INPUT) {
        if (is_initialised(now) && !isfinite(value)) {
            return fail(one, "input %s = %g: must be finite", v->name, value);
        }
        if (v->text[0] && value != 0.0 && !one->idle && !one->quiet) {
            say(one, WARNING, "%s = %g has no effect, %s", v->name, value, v->text);
            one->idle = 1;
        }
        now->inputs[k] = value;
        now->is_set[k] = 1;
        now->handed = -INFINITY;
        if (is_initialised(now)) {
            Run_set_input(&now->conduct.run, v->index, value);
        } else {
            now->ready = 0;
        }
    } else if (!is_initialised(now)) {
        now->parameters[k] = value + 0.0; /* never -0 */
        now->ready = 0;
    } else if (!v->tunable || v->kind != REAL) {
        return fail(one, "%s = %g: this parameter cannot change during a run", v->name, value);
    } else if (is_out_of_range(one, v, value)) {
        return 1;
    } else {
        now->parameters[k] = value + 0.0;
        now->tuned = 1;
    }
    return 0;
}

static int set_value(Instance *one, unsigned k, double value) {
    const int is_switch = variables[k].kind == BOOLEAN; /* any but 0 is true */
    return take_value(one, k, is_switch ? value != 0.0 : value) && refuse(one);
}

static int set_text(Instance *one, unsigned k, const char *text) {
    const Variable *v = &variables[k];
    if (strcmp(text, v->text) == 0) return 0;
    fail(one, "%s = '%s': this FMU was packed for '%s', on which its structure depends; pack "
         "another with --set %s=...", v->name, text, v->text, v->name);
    return refuse(one);
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
        Signals *signals = run->integrator->net->signals;
        for (int s = 0; s < SIGNALS; s++) Signals_from_zero(signals, s, run->time, 1, one->roads[s], 0);
        one->roads_known = 1;
    }
}

static void find_energies(Instance *one) {
    if (!one->energies_known) {
        Run *run = &one->now.conduct.run;
        Account_find(run->account, run->integrator, run->time);
        one->energies_known = 1;
    }
}

static double get_value(Instance *one, unsigned k) {
    State *now = &one->now;
    const Variable *v = &variables[k];
    if (v->causality == PARAMETER) return now->parameters[k];
    if (v->causality == INPUT) {
        return is_initialised(now) ? now->conduct.run.inputs->value[v->index]
                                : now->is_set[k] ? now->inputs[k] : v->start;
    }
    if (!now->ready && !is_initialised(now)) begin(one); /* reported at the end of initialisation */
    if (k == V_OK) return now->ready && now->ok;
    if (!now->ready || !now->ok) return v->kind == REAL ? NAN : 0.0;
    if (needs_forces(k)) find_forces(one);
    if (needs_roads(k)) find_roads(one);
    if (needs_energies(k)) find_energies(one);
    return find_output(&now->machine.integrator, &now->conduct.run, now->derived, one->roads, k);
}

/* Return the derivative at x of the polynomial that is 1 at place i and 0 at the other places 0, 1, ... */
static double slope_of(int i, double x) {
    double slope = 0.0;
    for (int j = 0; j < PLACES; j++) {
        double product = 1.0;
        if (j == i) continue;
        for (int m = 0; m < PLACES; m++) {
            if (m != i && m != j) product *= (x - m) / (i - m);
        }
        slope += product / (i - j);
    }
    return slope;
}

/* Find the derivative of an output by time at the present, within the last step.
 *
 * Displacements and velocities have velocities and accelerations. Others are read at some places of the
 * step, around the present as far as it allows; the derivative is that of the polynomial through them.
 */
static int find_rate(Instance *one, unsigned k, int order, double *rate) {
    Run *run = &one->now.conduct.run;
    const Dense *dense = run->integrator->dense;
    const double present = run->time, h = (dense->end - dense->start) / 64;
    const double first = fmax(dense->start, fmin(present - 2 * h, dense->end - 4 * h));
    double y[PLACES];
    if (!is_of_kind(one, k, REAL)) return 1;
    if (variables[k].causality != OUTPUT || order != 1) {
        return fail(one, "%s: only outputs have derivatives, of order 1", variables[k].name);
    }
    if (!one->now.ready || !one->now.ok) return fail(one, "there is no motion to take derivatives of");
    if (has_own_rate(k)) {
        find_forces(one);
        find_roads(one);
        *rate = find_own_rate(run->integrator, run, one->now.derived, one->roads, k);
        return 0;
    }
    *rate = 0.0;
    if (!is_continuous(k)) return 0;
    if (h <= 0.0) return fail(one, "%s: has no derivative before the first step", variables[k].name);
    for (int i = 0; i < PLACES; i++) {
        run->time = first + i * h;
        Integrator_sample(run->integrator, run->time);
        forget(one);
        y[i] = get_value(one, k);
    }
    run->time = present;
    Integrator_sample(run->integrator, present);
    forget(one);
    for (int i = 0; i < PLACES; i++) *rate += y[i] * slope_of(i, (present - first) / h) / h;
    return 0;
}

/* ---- whole state --------------------------------------------------------------------------- */

#define SERIALIZED (sizeof(Serialized))
#define NO_STATE "there is no state: get or deserialize one first"

typedef struct Serialized {
    char guid[sizeof GUID];
    unsigned long long sum; /* of the state: numbers of a damaged one may point anywhere */
    State state;
} Serialized;

/* Return the checksum of bytes (FNV-1a). */
static unsigned long long checksum_of(const void *bytes, size_t size) {
    unsigned long long sum = 14695981039346656037ULL;
    for (size_t k = 0; k < size; k++) sum = (sum ^ ((const unsigned char *) bytes)[k]) * 1099511628211ULL;
    return sum;
}

/* Write a state to bytes; return whether it failed. */
static int write_state(Instance *one, void *bytes, size_t size, const State *state) {
    char *to = bytes;
    unsigned long long sum;
    if (!state) return fail(one, NO_STATE);
    if (size < SERIALIZED) {
        return fail(one, "a state needs %lu bytes, not %lu", (unsigned long) SERIALIZED,
                    (unsigned long) size);
    }
    sum = checksum_of(state, sizeof *state);
    memset(to, 0, SERIALIZED);
    memcpy(to, GUID, sizeof GUID);
    memcpy(to + offsetof(Serialized, sum), &sum, sizeof sum);
    memcpy(to + offsetof(Serialized, state), state, sizeof *state);
    return 0;
}

/* Read a state from bytes to new memory if there is none; return whether it failed. */
static int read_state(Instance *one, const void *bytes, size_t size, State **state) {
    const char *from = bytes;
    unsigned long long sum;
    if (size != SERIALIZED || memcmp(from, GUID, sizeof GUID) != 0) {
        return fail(one, "this state belongs to another FMU");
    }
    memcpy(&sum, from + offsetof(Serialized, sum), sizeof sum);
    if (sum != checksum_of(from + offsetof(Serialized, state), sizeof(State))) {
        return fail(one, "this state is damaged");
    }
    if (!*state) *state = malloc(sizeof(State));
    if (!*state) return fail(one, "out of memory");
    memcpy(*state, from + offsetof(Serialized, state), sizeof(State));
    return 0;
}

static void free_state(void **state) {
    if (!state) return;
    free(*state);
    *state = NULL;
}

static int copy_state(Instance *one, State **state) {
    if (!*state) *state = malloc(sizeof(State));
    if (!*state) return fail(one, "out of memory");
    **state = one->now;
    return 0;
}

static int restore(Instance *one, const State *state) {
    if (!state) return fail(one, NO_STATE);
    one->now = *state;
    wire(one);
    /* forces are found from the motion read off the last step, which finding them changes */
    if (state->ready) Integrator_sample(&one->now.machine.integrator, state->conduct.run.time);
    return 0;
}

/* ---- directional derivatives ----------------------------------------------------------------- */

/* Find how outputs change if inputs and parameters do along a direction, the seed.
 *
 * The outputs of a step do not depend on inputs that are set after it. Those of the start follow inputs and
 * parameters: they are found for some values along the direction, on one side where the other is refused.
 */
static int find_sensitivity(Instance *one, const unsigned unknown[], size_t unknowns,
        const unsigned known[], size_t knowns, const double seed[], double sensitivity[]) {
    static const int firsts[] = {-2, 0, 1 - PLACES};
    State *start = NULL;
    double h = INFINITY;
    int status = 0;
    for (size_t k = 0; k < unknowns + knowns; k++) {
        if (!is_of_kind(one, k < unknowns ? unknown[k] : known[k - unknowns], REAL)) return 1;
    }
    if (one->now.refusal[0]) return fail(one, "%s", one->now.refusal);
    for (size_t k = 0; k < knowns; k++) {
        const Variable *v = &variables[known[k]];
        if (v->causality == OUTPUT || (v->causality == PARAMETER && is_initialised(&one->now))) {
            return fail(one, "%s: derivatives are by inputs, and before the end of initialisation by "
                        "parameters", v->name);
        }
        if (seed[k] != 0.0) {
            h = fmin(h, APART * fmax(fabs(get_value(one, known[k])), v->nominal) / fabs(seed[k]));
        }
    }
    for (size_t k = 0; k < unknowns; k++) {
        const Variable *v = &variables[unknown[k]];
        if (v->causality != OUTPUT) return fail(one, "%s: derivatives are of outputs", v->name);
        sensitivity[k] = 0.0;
    }
    if (is_initialised(&one->now) || h == INFINITY) return 0;
    if (copy_state(one, &start)) return 1;
    one->quiet = 1;
    for (size_t side = 0; side < sizeof firsts / sizeof firsts[0]; side++) {
        const int first = firsts[side];
        for (size_t k = 0; k < unknowns; k++) sensitivity[k] = 0.0;
        for (int i = 0; i < PLACES; i++) {
            const double weight = slope_of(i, -first) / h;
            restore(one, start);
            for (size_t k = 0; k < knowns; k++) {
                const double value = get_value(one, known[k]);
                set_value(one, known[k], value + (first + i) * h * seed[k]);
            }
            status = begin(one);
            if (status) break;
            for (size_t k = 0; k < unknowns; k++) {
                sensitivity[k] += weight * get_value(one, unknown[k]);
            }
        }
        if (status == 0) break;
    }
    restore(one, start);
    one->quiet = 0;
    free(start);
    return status;
}
