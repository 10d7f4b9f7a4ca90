# SPDX-License-Identifier: Apache-2.0
"""Reads POMDPX, the format of the APPL toolkit: XML, tables and decision diagrams.

Takes text. Gives a ``ForeignModel``.
"""
