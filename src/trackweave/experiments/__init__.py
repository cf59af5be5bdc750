"""Studies of a user's own."""
