"""Many runs of one model with different parameters: `run_many`, and its results as columns."""

from .runs import Outcome, outputs_at_end, outputs_over_time, run_many

__all__ = ["Outcome", "outputs_at_end", "outputs_over_time", "run_many"]
