"""What reports cost by whom they say they are."""

import math


def whose(said):
    """Return who a sequence is, and who its last report said if that was not the same."""
    # One named twice in a row is who it is from then on.
    taken, other = None, None
    for name in said:
        if taken is None or name == other:
            taken = name
        other = name if name != taken else None
    return taken, other


def is_own(view, index, said):
    """Tell whether a report names who a sequence is."""
    identity = view.scan.identity
    return bool(said) and identity is not None and identity[index] == whose(said)[0]


def naming(view, index, said, n_identities):
    """Return what it costs that a report names somebody, after what was said before [nats]."""
    own = -1 if view.scan.identity is None else int(view.scan.identity[index])
    if own < 0 or not said:
        return 0.0
    error = view.sensor.identity_error
    taken, other = whose(said)
    if own == taken:
        return -math.log((1 - error) * n_identities + error)
    return 0.0 if own == other else -math.log(error)


def taken(views, view, index):
    """Return what a new object costs where a report before its scan had its identity [nats]."""
    if view.scan.identity is None or view.scan.identity[index] < 0:
        return 0.0
    earlier = views[: next(place for place, each in enumerate(views) if each is view)]
    named = [each.scan.identity for each in earlier if each.scan.identity is not None]
    is_taken = any(view.scan.identity[index] in each for each in named)
    return -math.log(view.sensor.identity_error) if is_taken else 0.0
