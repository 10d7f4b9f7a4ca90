# SPDX-License-Identifier: Apache-2.0
"""Episodes as offline pages: the world, the tree of each decision, and curves on one time line."""

from hypgen.views.page import page_of
from hypgen.views.recorded import view_of_recording
from hypgen.views.view import entries_of, view_of

__all__ = ["entries_of", "page_of", "view_of", "view_of_recording"]
