"""Records simulated from a noise model: in memory, or straight into a file however long they are."""

from sigmatau.model.simulation.imperfections import Imperfections, Outage, Temperature, WarmUp
from sigmatau.model.simulation.memory import simulate
from sigmatau.model.simulation.stream import Simulated, simulate_to

__all__ = ["Imperfections", "Outage", "Simulated", "Temperature", "WarmUp", "simulate", "simulate_to"]
