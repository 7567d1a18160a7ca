"""Where a step leaves its branch, how it is made to end there, and what changes with the branch."""
