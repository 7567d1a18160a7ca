"""Studies of the integrator itself: its error against its run time, its stability."""
