"""Interfaces of the ROS 2 package visualization_msgs."""
