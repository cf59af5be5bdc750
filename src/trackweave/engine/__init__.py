"""Many processes or machines behind one thin protocol: submit, gather, place, be told of a death.

``engine_of`` finds an engine by its name: ``local``, processes of this machine; ``ray``, Ray on
this machine; ``ray://HOST``, a cluster of Ray. What is computed depends on the tasks alone, never
on the engine or on how many workers there are. Only ``trackweave.engine.on_ray`` imports Ray.
"""

from trackweave.engine.choice import engine_of, require_engine
from trackweave.engine.keeping import kept_engine
from trackweave.engine.pool import Pool
from trackweave.engine.protocol import Actor, Engine, EngineError, Outcome, WorkerLostError
from trackweave.engine.serving import is_worker

__all__ = [
    "Actor",
    "Engine",
    "EngineError",
    "Outcome",
    "Pool",
    "WorkerLostError",
    "engine_of",
    "is_worker",
    "kept_engine",
    "require_engine",
]
