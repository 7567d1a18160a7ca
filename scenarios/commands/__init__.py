"""The commands of `phaseplane`, a module for each group; what they do stands elsewhere."""
