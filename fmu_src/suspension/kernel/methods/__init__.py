"""The methods that step the motion while no branch changes; `registry` has them by name."""
