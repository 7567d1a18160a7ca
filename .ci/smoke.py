"""A smoke test of what is installed: `python -P .ci/smoke.py compiled` (or `uncompiled`)."""

import sys

from phaseplane.suspension import engine
from phaseplane.suspension.session import simulate

wanted = sys.argv[1] == "compiled"
assert engine.compiled == wanted, engine.why_uncompiled or "compiled, where nothing should be"
columns = simulate("QuarterCar", {}, [0.01 * k for k in range(101)], ["contact_force"])
assert min(columns["contact_force"]) == 0.0, "the wheel does not lift off"
print(f"{sys.version.split()[0]} on {sys.platform}: {sys.argv[1]}, and the wheel lifts off")
