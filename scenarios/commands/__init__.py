"""The commands of `phaseplane`, one module for each group; the work is done in the other folders."""
