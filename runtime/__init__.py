# SPDX-License-Identifier: Apache-2.0
"""The C++ solver library's sources, and the package that builds with them (``builder``)."""
