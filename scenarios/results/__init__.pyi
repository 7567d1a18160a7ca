from . import comparison as comparison
