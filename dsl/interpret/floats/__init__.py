# SPDX-License-Identifier: Apache-2.0
"""Float functions and random words in numpy, with the bits that the C++ runtime gives.

Takes arrays. Gives arrays; each module mirrors a header of ``runtime/include/hypgen``.
"""
