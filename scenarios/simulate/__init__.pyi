from . import driver as driver
from . import solving as solving
