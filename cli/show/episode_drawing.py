# SPDX-License-Identifier: Apache-2.0
"""What ``hypgen sim`` draws of an episode: where it stands, and what exact posteriors believe."""

from __future__ import annotations

import os
import sys
from typing import Any

from hypgen.cli.show.scene_text import scene_lines
from hypgen.dsl.interpret.episode import Episode
from hypgen.dsl.interpret.factor_samples import factor_samples
from hypgen.dsl.interpret.scenes import Scenes

_SAMPLES = 500


class EpisodeDrawing:
    """Draws an episode; without ``hidden``, what the agent does not see is drawn only as it is believed."""

    def __init__(self, episode: Episode, hidden: bool) -> None:
        self._episode = episode
        self._hidden = hidden
        self._scenes = Scenes(episode.model)
        self.scene = self._scenes.scene()
        """What holds for the whole episode, as ``Scenes.scene`` gives it; None without drawings."""

    def moment(self) -> dict[str, Any]:
        """Return the shapes of where the episode stands: ``truth``, and what ``Scenes.belief`` gives."""
        values = self._episode.values()
        sampled = factor_samples(self._episode.model, self._episode.belief(), _SAMPLES)
        truth = self._scenes.truth(values, hidden=self._hidden)
        return self._scenes.belief(values, sampled) | {"truth": truth}

    def lines(self) -> list[str]:
        """Return the lines of where the episode stands, in colour for a terminal; none without drawings."""
        if self.scene is None:
            return []
        coloured = sys.stdout.isatty() and not os.environ.get("NO_COLOR")
        return scene_lines(self.scene, self.moment(), coloured=coloured)
