# SPDX-License-Identifier: Apache-2.0
"""The parts of a model: declarations, updates, observations, rewards, bounds, policies.

Takes one item of the file. Gives the part of ``ir.Model`` that it stands for.
"""
