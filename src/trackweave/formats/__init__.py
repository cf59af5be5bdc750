"""One file for each format: how it is found, read and written.

``registry`` lists them, with those that other packages bring by the entry points
``trackweave.readers`` and ``trackweave.writers``; ``format`` says what one is.
"""
