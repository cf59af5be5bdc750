"""The live service: reports in over the network, tracks out, a page with a live map.

``journal`` and ``snapshots`` keep what came in and what was decided; ``desk`` is the counter
between those who ask (``web``) and the clerk who keeps the journal and feeds the engine. Needs
the extra ``service``.
"""
