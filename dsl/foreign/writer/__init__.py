# SPDX-License-Identifier: Apache-2.0
"""Writes a ``ForeignModel`` as text of this language.

Takes tables of numbers. Gives a model that a person can read, large tables as shared rows.
"""
