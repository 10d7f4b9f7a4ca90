# SPDX-License-Identifier: Apache-2.0
"""C++ text of types, names, literals, expressions and distributions.

Takes IR nodes. Gives lines of C++.
"""
