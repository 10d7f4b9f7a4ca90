# SPDX-License-Identifier: Apache-2.0
"""Models in other people's formats: recognised, read, and written as text of this language.

Takes files in Cassandra's format and POMDPX. Gives text of a ``.pomdp`` file (``reader.import_text``).
Imports the standard library and ``hypgen.dsl.messages`` alone.
"""
