# SPDX-License-Identifier: Apache-2.0
"""The ``hypgen`` command line: the only layer that prints or exits.

Takes arguments. Gives output and an exit code; ``main`` finds the command's module.
"""
