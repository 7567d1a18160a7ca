from . import constructions as constructions
from . import energies as energies
from . import live as live
from . import pictures as pictures
from . import planes as planes
from . import recording_content as recording_content
