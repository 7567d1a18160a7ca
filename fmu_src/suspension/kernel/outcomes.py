"""How attempts and runs end: 0 as requested, otherwise why, mostly a key of `FAILURES`."""

REACHED, PAUSED, DIVERGED, STEP_TOO_SMALL = 0, 1, 2, 3
NOT_CONVERGED, NOT_POSITIVE, UNSTABLE, ENERGY_GROWS = 4, 5, 6, 7
NO_TIME_PASSES, TOO_MANY, NO_MASS, OUT_OF_BALANCE = 8, 9, 10, 11
INTERRUPTED = 12
HALTED = -1  # at a switch or step that the host wants to see, before the time requested
AT_SWITCHES, AT_STEPS = 1, 2  # where a run halts for the host; 0: nowhere

# Why a run of steps ended early; what to try is in `suspension.reasons`.
FAILURES = {
    DIVERGED: "the motion has diverged",
    STEP_TOO_SMALL: "the step has become too small",
    NOT_CONVERGED: "no equilibrium was found at the end of a step",
    NOT_POSITIVE: "the matrix of a step is not positive definite",
    UNSTABLE: "solver.step is longer than the largest stable step",
    ENERGY_GROWS: "energy grows without external work",
    NO_TIME_PASSES: "switches follow one another without time between them",
    TOO_MANY: "the run needs more than 30 million steps",
    NO_MASS: "the mass matrix must be symmetric and positive definite",
    OUT_OF_BALANCE: "the energy balance is off by more than all energy stored or supplied",
    INTERRUPTED: "the run was interrupted",
}
