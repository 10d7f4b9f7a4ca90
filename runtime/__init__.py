"""The C++ solver library's sources, and the package that builds with them (``builder``)."""
