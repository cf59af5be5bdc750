"""How objects move, what sensors measure, and on which plane."""
