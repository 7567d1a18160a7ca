"""Changes of branch: found from the state, logged, and booked in the ledger."""

from __future__ import annotations

from ..arrays import Memory
from ..energy.ledger import Ledger
from ..layout import BRANCHES, CONTACT, SPRING
from ..motion.motion import Motion
from ..network.network import Network
from .jumps import Jumps
from .limited import Limited
from .switch_log import SwitchLog


class Transitions:
    """Moves elements from one branch to another at the present time."""

    def __init__(
        self,
        memory: Memory,
        network: Network,
        motion: Motion,
        ledger: Ledger,
        limited: Limited,
        noted: SwitchLog,
    ) -> None:
        self.net, self.motion, self.ledger = network, motion, ledger
        self.elements, self.branches = self.net.elements, self.net.branches
        self.signals = self.net.signals
        self.limited, self.noted = limited, noted
        self.state = self.motion.state
        self.jumps = Jumps(self.net)
        self.before = memory.marks(BRANCHES * self.elements.count)

    def energy(self) -> float:
        """Return kinetic energy and the energy stored in the elements, in the present branches."""
        self.signals.all_signals(self.state.time)
        self.elements.row_states(self.motion.q, self.motion.v)
        return self.net.energy(self.motion.v)

    def switch(self, e: int, kind: int, side: int) -> None:
        """Move element e to the neighbouring branch, and log that."""
        self._leave_step()
        before = self.elements.branch[BRANCHES * e + kind]
        new = self.branches.enter(e, kind, side, self.state.time, self.motion.q, self.motion.v)
        if self.elements.yields[e] and kind < CONTACT:
            before = new - side  # a change of sign of the rate ends the flow of the spring
            kind = SPRING
        self.noted.note(self.state.time, e, kind, before, new)

    def relocate(self, flows: bool) -> None:
        """Choose the branches from the state, with those of flow if `flows`; log the changes."""
        self.remember()
        if flows:
            self.branches.follow(self.state.time, self.motion.q, self.motion.v)
        else:
            self.branches.locate_branches(self.state.time, self.motion.q, self.motion.v)
        self.note()

    def remember(self) -> None:
        """Store the branches before new ones are chosen."""
        self._leave_step()
        for i in range(BRANCHES * self.elements.count):
            self.before[i] = self.elements.branch[i]

    def note(self) -> None:
        """Log the changes since then."""
        for i in range(BRANCHES * self.elements.count):
            if self.elements.branch[i] != self.before[i]:
                e, kind = i // BRANCHES, i % BRANCHES
                self.noted.note(self.state.time, e, kind, self.before[i], self.elements.branch[i])

    def book_contacts(self) -> None:
        """Book the exchange of tyres that have just left or met the road, which is not work of a road."""
        for k in range(self.limited.count):
            e = self.limited.element[k]
            at = BRANCHES * e + CONTACT
            if self.elements.branch[at] != self.before[at]:
                self.branches.book_exchange(e, self.state.time, self.motion.q, self.motion.v)

    def pass_joint(self) -> None:
        """Enter the next segments of signals; the effect of a jump of a road is work of that road."""
        self._leave_step()
        before = self.energy()
        before -= self.state.exchange
        jumped = False
        for s in range(self.signals.count):
            jump = self.signals.enter_segment(s, self.state.time)
            if jump != 0.0:
                jumped = True
                self.jumps.kerb(s, jump, self.motion.v)
                self.relocate(False)
                self.book_contacts()
                now = self.energy()
                now -= self.state.exchange
                self.ledger.bring_in(s, now - before)
                before = now
        if not jumped:
            self.remember()
            self.branches.follow_slips(self.state.time, self.motion.q, self.motion.v)
            self.note()

    def _leave_step(self) -> None:
        """Store the branches of the step that ends here before they change."""
        if self.state.in_step:
            self.branches.keep_branches()
            self.state.in_step = False
