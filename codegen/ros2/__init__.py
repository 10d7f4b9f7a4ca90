# SPDX-License-Identifier: Apache-2.0
"""The ROS 2 packages of a model.

Takes an ``ir.Model``. Gives what the templates of its message package and of its node lay out.
"""
