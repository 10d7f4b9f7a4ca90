"""The C++ solver library's sources and the Python side that finds compilers and builds with them."""
