"""Rewrites and analyses of IR that C++ needs: tables, guards, hoisting, read sets, partition.

Takes IR. Gives IR or facts about it; prints nothing.
"""
