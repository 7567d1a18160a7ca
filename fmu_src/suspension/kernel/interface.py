"""What Python uses of the kernel."""

from .integrator import Integrator
from .methods.method import Method
from .methods.registry import METHODS
from .network.elements import KINDS
from .network.network import Network, laws_of
from .network.rest import Rest
from .outcomes import FAILURES
from .runs.account import Account
from .runs.contacts import Contacts
from .runs.filling import Filling
from .runs.lines import Lines
from .runs.run import Run
from .runs.run_queue import RunQueue

__all__ = [
    "FAILURES",
    "KINDS",
    "METHODS",
    "Account",
    "Contacts",
    "Filling",
    "Integrator",
    "Lines",
    "Method",
    "Network",
    "Rest",
    "Run",
    "RunQueue",
    "laws_of",
]
