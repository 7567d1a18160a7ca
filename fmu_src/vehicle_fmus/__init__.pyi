from . import build as build
from . import native as native
