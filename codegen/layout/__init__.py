# SPDX-License-Identifier: Apache-2.0
"""Names and places in the generated code: C++ names, bit fields of the state, fields of the history.

Takes an ``ir.Model``. Gives where each variable lies and what it is called; prints nothing.
"""
