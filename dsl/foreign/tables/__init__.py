# SPDX-License-Identifier: Apache-2.0
"""Models as readers of other formats give them and the writer takes them: variables and tables.

Takes rows and names of a foreign file. Gives a ``ForeignModel``; ``trouble`` gathers mistakes.
"""
