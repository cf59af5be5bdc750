"""The live service: reports in over the network, tracks out, a page with a live map.

``desk`` is the counter between those who ask (``web``) and the clerk who keeps the journal and
feeds the engine. Needs the extra ``service``.
"""
