# SPDX-License-Identifier: Apache-2.0
"""C++ as a tree: expressions, statements and functions, and their text.

Takes what printers of the IR put together. Gives lines of C++.
"""
