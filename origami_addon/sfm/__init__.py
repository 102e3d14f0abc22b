"""Structure from motion: the worker (pycolmap, its own process) and the client that starts, follows and kills it."""
