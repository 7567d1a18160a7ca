"""Nonlinear vehicle-suspension models and the incremental integrator that steps them.

What an FMU carries needs the standard library only. The integrator may be compiled; if it is not, or if
the compiled file does not fit this interpreter or its source, the same source runs uncompiled.
"""
