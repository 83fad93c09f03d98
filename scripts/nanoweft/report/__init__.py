"""One HTML page of a run that needs nothing else: no network, no server."""
