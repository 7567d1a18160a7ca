"""The end of a Python process that has hosted an FMU, as text for `python -c`."""

# the wrapper's own end of a process reads what is freed already, and now and then aborts
LEAVE = """
import os, sys
sys.stdout.flush()
os._exit(0)
"""
