"""One module for each command of ``hypgen``; ``command`` in it is the click command."""
