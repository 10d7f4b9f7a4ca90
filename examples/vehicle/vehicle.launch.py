# SPDX-License-Identifier: Apache-2.0
"""Starts the planner's node and the bridge: ros2 launch vehicle.launch.py exits:="[0.0, 5.0, 40.0, 5.0]"."""

import sys
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration

HERE = Path(__file__).resolve().parent


def generate_launch_description():
    """Return what `ros2 launch` does."""
    planner = Path(get_package_share_directory("vehicle_planner"), "launch", "vehicle_planner.launch.py")
    words = ["--ros-args", "-p", ["period:=", LaunchConfiguration("period")]]
    words += ["-p", ["exits:=", LaunchConfiguration("exits")]]
    return LaunchDescription(
        [
            DeclareLaunchArgument("period", default_value="0.3333"),
            DeclareLaunchArgument("exits", default_value="[0.0, 0.0]"),
            IncludeLaunchDescription(PythonLaunchDescriptionSource(str(planner))),
            ExecuteProcess(
                cmd=[sys.executable, "-m", "vehicle.ros2_node", *words], cwd=str(HERE.parent), output="screen"
            ),
        ]
    )
