"""States as compiled loops hand them out: tuples without names.

For a named tuple numba calls its class, which is code of Python. Ctrl-C that came while the loop
ran is heard there, and numba goes on with what has not been made: the process dies. Tuples of
numbers are made where nobody listens, and get their names when the loop has returned.
"""

from bdt_plant.machine import MachineState
from bdt_plant.motor import MotorState
from bdt_plant.plant import PlantState
from bdt_plant.stiffening_tower import TowerState
from bdt_plant.structure import StructureState

Floats = tuple[float, ...]
UnnamedPlant = tuple[Floats, float, int, Floats]
UnnamedMachine = tuple[Floats, float, int, Floats, int, float]


def unnamed_plant(state: PlantState) -> UnnamedPlant:
    """Return a state of the plant without names; compiled into loops."""
    return state.motor[:], state.theta_d, state.contact, state.structure[:]


def named_plant(state: UnnamedPlant) -> PlantState:
    """Return what :func:`unnamed_plant` was given."""
    motor, theta_d, contact, structure = state
    return PlantState(MotorState(*motor), theta_d, contact, StructureState(*structure))


def unnamed_machine(state: MachineState) -> UnnamedMachine:
    """Return a state of a mechanism that is not linear without names; compiled into loops."""
    motor, tower = state.motor[:], state.structure[:]
    return motor, state.theta_d, state.contact, tower, state.sample, state.voltage


def named_machine(state: UnnamedMachine) -> MachineState:
    """Return what :func:`unnamed_machine` was given."""
    motor, theta_d, contact, tower, sample, voltage = state
    structure = TowerState(*tower)
    return MachineState(MotorState(*motor), theta_d, contact, structure, sample, voltage)
