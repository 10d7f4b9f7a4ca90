# SPDX-License-Identifier: Apache-2.0
"""Pictures of episodes: one step as PNG, a whole one as GIF. Needs the extra ``draw``."""

from hypgen.pictures.render import render_gif, render_png

__all__ = ["render_gif", "render_png"]
