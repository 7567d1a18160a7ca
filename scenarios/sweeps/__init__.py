"""One scene run many times, with other values each time."""
