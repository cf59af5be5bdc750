"""How objects move between reports: one module for each way to move."""

from trackweave.models.motion.constant_acceleration import (
    CONSTANT_ACCELERATION,
    ConstantAcceleration,
)
from trackweave.models.motion.constant_velocity import CONSTANT_VELOCITY, ConstantVelocity
from trackweave.models.motion.coordinated_turn import COORDINATED_TURN, CoordinatedTurn
from trackweave.models.motion.imm import MODELS, Imm, Mode, Motion
from trackweave.models.motion.random_walk import RANDOM_WALK, RandomWalk
from trackweave.models.motion.rule import PROCESS_NOISE, USUAL_PROCESS, USUAL_SPEED, MotionRule

__all__ = [
    "CONSTANT_ACCELERATION", "CONSTANT_VELOCITY", "COORDINATED_TURN", "MODELS", "PROCESS_NOISE",
    "RANDOM_WALK", "USUAL_PROCESS", "USUAL_SPEED", "ConstantAcceleration", "ConstantVelocity",
    "CoordinatedTurn", "Imm", "Mode", "Motion", "MotionRule", "RandomWalk",
]  # fmt: skip
