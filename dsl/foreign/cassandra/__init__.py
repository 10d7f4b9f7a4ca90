# SPDX-License-Identifier: Apache-2.0
"""Reads Cassandra's format (pomdp.org): tokens, tables, rewards.

Takes text. Gives a ``ForeignModel``.
"""
