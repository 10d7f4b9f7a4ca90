# SPDX-License-Identifier: Apache-2.0
"""A generated ROS 2 node, compiled and driven without ROS."""
