"""Reads Cassandra's format (pomdp.org): tokens, tables, rewards.

Takes text. Gives a ``ForeignModel``.
"""
