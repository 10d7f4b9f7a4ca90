# SPDX-License-Identifier: Apache-2.0
"""Scopes, which expressions are checked in: names, the expected type, units, and known facts.

Takes syntax of types and the model's symbols. Gives scopes, types and fitted values.
"""
