# SPDX-License-Identifier: Apache-2.0
"""Records of floats taken apart on the syntax tree, before any name is resolved.

Takes a file's syntax tree. Gives one in which each such record is the scalars in it.
"""
