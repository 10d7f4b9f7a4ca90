# SPDX-License-Identifier: Apache-2.0
"""``hypgen fmt``: the one layout of a model's text.

Takes a source. Gives text with the same tokens and comments; ``formatter.format_source`` is the way in.
"""
