"""Studies of a user's own: scenarios × configurations × seeds, on any engine.

``study_file`` reads and checks what is asked for, ``cases`` carries out one run, ``running``
all of them, each kept as it comes; ``tables`` and ``report`` tell what came out; ``tuning``
searches. The source
documents' own studies are in ``trackweave.studies``, whose intervals are used here.
"""

from trackweave.experiments.studying import StudyResult, study
from trackweave.experiments.tuning import TuningResult, tune

__all__ = ["StudyResult", "TuningResult", "study", "tune"]
