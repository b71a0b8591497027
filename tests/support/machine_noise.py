"""Residuals of a machine that is not quite its model, from the equations written out."""

import math

import numpy as np

from bdt_plant.structure import StructureParameters, discretize_structure
from bdt_twin.innovations import DeviationModel, Motion, NoiseLevels, Whitening

BLOCK_TIME = 5e-3
STEP = discretize_structure(StructureParameters(), BLOCK_TIME)
LEVELS = NoiseLevels(reading=1e-6, fast=1e-5, slow=4e-5, force=2e-5)
VELOCITIES = (1, 3)


def random_motion(blocks, seed=0):
    """Return a motor that stops, turns slowly and fast, and is in contact now and then."""
    random = np.random.default_rng(seed)
    kind = np.repeat(random.integers(3, size=blocks // 10 + 1), 10)[:blocks]
    contact = np.repeat(random.integers(2, size=blocks // 7 + 1), 7)[:blocks]
    return Motion(
        BLOCK_TIME * (kind == 2).astype(float),
        BLOCK_TIME * (kind == 1).astype(float),
        contact.astype(float),
    )


def moving(blocks, contact=1.0):
    """Return a motor that turns fast all the time, in contact or not."""
    return Motion(np.full(blocks, BLOCK_TIME), np.zeros(blocks), np.full(blocks, contact))


def walk_of(motion, levels):
    """Return the variance of the motor's walk in each block [m^2]."""
    return levels.fast**2 * motion.fast + levels.slow**2 * motion.slow


def positions_after(motion, walk, kicks, forces=()):
    """Return the deviation of q3 at all blocks for given noise: the equations, written out.

    ``walk`` is what the motor does [m], ``kicks`` what is added to the velocities before a block
    [m/s] and ``forces`` after it, shape (blocks, 2).
    """
    rows = np.array(STEP)
    structure, screw, motor = np.zeros(4), 0.0, 0.0
    found = np.zeros(walk.size)
    for block in range(1, walk.size):
        motor += walk[block]
        before, screw = screw, motor if motion.contact[block] else screw
        structure[list(VELOCITIES)] += kicks[block]
        structure = rows @ np.concatenate([structure, [before, screw]])
        if len(forces):
            structure[list(VELOCITIES)] += forces[block]
        found[block] = structure[2]
    return found


def simulated(motion, levels, seed):
    """Return a residual of a machine that has just this noise."""
    random, count = np.random.default_rng(seed), motion.contact.size
    walk = np.sqrt(walk_of(motion, levels)) * random.standard_normal(count)
    forces = levels.force * math.sqrt(BLOCK_TIME) * random.standard_normal((count, 2))
    return positions_after(
        motion, walk, np.zeros((count, 2)), forces
    ) + levels.reading * random.standard_normal(count)


def whitening(motions, levels, residual, threshold=math.inf):
    model = DeviationModel(STEP, BLOCK_TIME, motions)
    return Whitening(model, levels, residual, threshold)
