"""Interfaces of the ROS 2 package trajectory_msgs."""
