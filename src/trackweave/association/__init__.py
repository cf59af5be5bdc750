"""The assignment problem, and the tree of scored sequences that it is made from."""
