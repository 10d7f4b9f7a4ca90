"""Reads POMDPX, the format of the APPL toolkit: XML, tables and decision diagrams.

Takes text. Gives a ``ForeignModel``.
"""
