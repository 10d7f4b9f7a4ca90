# SPDX-License-Identifier: Apache-2.0
"""Messages to an author: sources, places in them, diagnostics, their texts, and the one renderer.

Takes mistakes as data. Gives text with a framed excerpt, or JSON. Modules whose names begin with a group of
codes hold the texts. Each function there is one message: it takes what is wrong, then where, then the places
of notes, and returns the ``Diagnostic``.
"""
