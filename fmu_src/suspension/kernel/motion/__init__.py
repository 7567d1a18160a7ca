"""The equation of motion in the present branches, and the motion: its ends, its errors, and between."""
