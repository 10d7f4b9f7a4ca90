"""Models in other people's formats: Cassandra's and POMDPX are read, and written as text of this language.

Imports the standard library, and of ``hypgen.dsl`` diagnostics and source alone.
"""
