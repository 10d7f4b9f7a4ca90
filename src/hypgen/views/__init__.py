# SPDX-License-Identifier: Apache-2.0
"""Episodes as offline pages: the world, the tree of each decision, and curves on one time line."""

from hypgen.views.page import page_of
from hypgen.views.recorded import view_of_recording
from hypgen.views.view import entries_of, most_nodes, shown_step, view_of

__all__ = ["entries_of", "most_nodes", "page_of", "shown_step", "view_of", "view_of_recording"]
