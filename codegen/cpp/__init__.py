# SPDX-License-Identifier: Apache-2.0
"""C++ of types, names, literals, expressions and distributions.

Takes IR nodes. Gives trees of C++.
"""
