"""Interfaces of the ROS 2 package shape_msgs."""
