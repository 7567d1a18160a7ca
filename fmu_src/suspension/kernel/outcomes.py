"""How attempts and runs end: 0 as requested, otherwise why, mostly a key of `integrator.FAILURES`."""

REACHED, PAUSED, DIVERGED, STEP_TOO_SMALL = 0, 1, 2, 3
NOT_CONVERGED, NOT_POSITIVE, UNSTABLE, ENERGY_GROWS = 4, 5, 6, 7
NO_TIME_PASSES, TOO_MANY, NO_MASS, OUT_OF_BALANCE = 8, 9, 10, 11
INTERRUPTED = 12
HALTED = -1  # at a switch or step that the host wants to see, before the time requested
