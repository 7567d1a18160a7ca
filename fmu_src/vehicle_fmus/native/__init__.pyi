from . import pack as pack
