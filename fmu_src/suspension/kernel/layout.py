"""Names for the offsets of the numbers of branches, pieces and segments.

`pieces.Piece` and `signals.Segment` give their numbers in this order.
"""

# stands for a bound, a limit or an instant that does not exist
UNBOUNDED = 1e300
# the kinds of branches of an element: `branch[BRANCHES e + kind]`
SPRING, DAMPER, MODULATION, CONTACT, FRICTION = 0, 1, 2, 3, 4
BRANCHES = 5
# laws of each element: spring, damper, modulation of the damper
LAWS = 3

# of a piece of a law, and of a segment of a signal: c0 + c1 s + c2 s^2 + c3 s^3 from its start,
# with s = x - origin
START, ORIGIN, C0, C1, C2, C3 = 0, 1, 2, 3, 4, 5
# of a piece: + saturation tanh(s / scale) + power |s|^exponent sgn s; the energy stored at its start;
# whether there is a function in Python
SATURATION, SCALE, STORED, POWER, EXPONENT, OWN = 6, 7, 8, 9, 10, 11
# numbers of a piece
PIECE = 12
# of a segment: + amplitude cos(angle + speed s + chirp s^2)
AMPLITUDE, ANGLE, SPEED, CHIRP = 6, 7, 8, 9
# numbers of a segment
SEGMENT = 10
