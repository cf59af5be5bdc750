"""Tables in, checked once value by value, and files out, whole or not at all.

Reading goes in three steps: a file or table becomes a table of raw columns (``tables``), its
cells become checked numbers and text (``columns``, ``times``, ``checks``), and these become
values of ``trackweave.domain`` (``reports``, ``truth``, ``tracks_in``). Writing goes through data
frames (``frames_out``) and bytes (``encoding``) to a directory (``output``).
"""
