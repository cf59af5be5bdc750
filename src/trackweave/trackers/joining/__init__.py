"""Which tracks of a finished record are one object's, seen again after a silence."""
