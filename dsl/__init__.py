# SPDX-License-Identifier: Apache-2.0
"""Text to a checked, typed model; knows nothing of C++.

Takes the files that an author writes. Gives an ``ir.Model``, or every independent mistake as a
``Diagnostic``. ``load.load`` is the way in; ``pipeline`` lists the passes. README.md lists the rooms.
"""
