"""A car of which optima are sought and to which parameters are fitted."""

from command_line import written

CAR = """
fmu = "QuarterCar"
duration = "0.6 s"
[parameters]
road.height = "2 cm"
"""

SEARCH = "[search]\npopulation = 4\ngenerations = 6\ntrade_offs = 4\n"

SHORT = (
    'minimise = "rms.body_displacement"\n[vary]\nspeed = { from = 5, to = 10 }\n'
    "[search]\npopulation = 1\ngenerations = 0\n"
)


def study(text):
    return written(f'scene = "car.toml"\n{text}', "study.toml")
