# SPDX-License-Identifier: Apache-2.0
"""Upper bounds that the compiler derives: groups of rewards as small models of their own.

Takes the model's rewards and updates. Gives the groups, and their functions in C++.
"""
