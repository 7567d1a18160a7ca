"""Studies of the integrator and the constructions: accuracy, run time, stability, model choice."""
