from . import energies as energies
