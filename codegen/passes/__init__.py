# SPDX-License-Identifier: Apache-2.0
"""Rewrites and analyses of IR that C++ needs: tables, guards, hoisting, read sets, partition.

Takes IR. Gives IR or facts about it; prints nothing.
"""
