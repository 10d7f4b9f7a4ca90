"""IR to ``{path: text}`` of a C++ project: pure, deterministic, and the only user of Jinja2."""
