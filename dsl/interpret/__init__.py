# SPDX-License-Identifier: Apache-2.0
"""The reference semantics of a model, in numpy, for many lanes at once.

Takes an ``ir.Model``. Gives states, observations, rewards and posteriors, step by step.
"""
