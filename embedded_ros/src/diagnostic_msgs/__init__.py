"""Interfaces of the ROS 2 package diagnostic_msgs."""
