# SPDX-License-Identifier: Apache-2.0
"""Conclusions from who reads what in a model: stages, orders, independence.

Takes expressions of ``ir`` and recorded reads. Gives orders, marks and factors; refuses circles.
"""
