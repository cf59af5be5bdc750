"""Whether compiled kernels are at hand, so that nobody takes compiling for hanging."""

from pathlib import Path

__all__ = ["kernels_are_kept"]


def kernels_are_kept() -> bool:
    """Tell whether an earlier run left compiled kernels on the disk.

    Returns
    -------
    False on the first run of an installation, and where no folder can be written.
    """
    from trackweave.filters import _kernels

    # Without just-in-time compilation kernels are plain functions, which need no waiting.
    stats = getattr(_kernels.predict, "stats", None)
    if stats is None:
        return True
    return stats.cache_path is not None and any(Path(stats.cache_path).glob("_kernels.*.nbi"))
