"""What others reach over the network: routes, the stream, login, the page; and who may.

``application`` makes of a desk and ``WebSettings`` an ASGI application; ``server`` lets it be
reached. Needs the extra ``service``.
"""
